// SPDX-License-Identifier: BSD-3-Clause
// Reads one file with a third-party library for another process. Not to be started by hand.
#include "ReaderProgram.h"

int main(int argumentCount, char** arguments)
{
  return bsv::readerProgram(argumentCount, arguments);
}
