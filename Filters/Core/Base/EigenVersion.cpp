// SPDX-License-Identifier: BSD-3-Clause
#include "Base/Types.h"

extern "C" const char BSV_EIGEN_SYMBOL = 0;
