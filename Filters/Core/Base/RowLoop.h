// SPDX-License-Identifier: BSD-3-Clause
/// @file RowLoop.h
/// BSV_ROW_LOOP before a function makes the compiler build it for several vector units, of which the machine's is
/// chosen when the library is loaded. Results are the same bits for all of them: nothing is reordered or fused.
///
/// For functions that are little but a loop over rows of numbers. Functions called in the loop prevent its vector code.
#pragma once

// What chooses runs before the thread sanitizer is there, which it calls: programs would crash at their start.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__) &&                       \
  !defined(__SANITIZE_THREAD__)
#define BSV_ROW_LOOP __attribute__((target_clones("avx512f", "avx2", "default"), noinline))
#else
#define BSV_ROW_LOOP
#endif
