// SPDX-License-Identifier: BSD-3-Clause
// Writes one file with a third-party library for another process. Not to be started by hand.
#include "WriterProgram.h"

int main(int argumentCount, char** arguments)
{
  return bsv::writerProgram(argumentCount, arguments);
}
