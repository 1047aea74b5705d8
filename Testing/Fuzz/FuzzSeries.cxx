// SPDX-License-Identifier: BSD-3-Clause
// Lists of the files of a series.
#include "FuzzSupport.h"

#include "Formats/SeriesList.h"

#include <cmath>

BSV_FUZZ_WORDS("{", "}", "[", "]", ":", "\"files\"", "\"name\"", "\"time\"", "\"file-series-version\"", "\"\"",
  "\"a.series\"", "{\"name\": \"b.nmf\", \"time\": 2},", "\\u00fc", "\\ud83d\\ude00", "\\ud800", "\\u0000", "\\n",
  "true", "null")

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  fuzz::parse([&] {
    double last = -HUGE_VAL;
    for (const bsv::SeriesFile& file : bsv::readSeriesList(fuzz::fileWith(data, size)))
    {
      // What is read can be opened and is in order.
      if (file.name.empty() || file.name.find('\0') != std::string::npos || !(file.time > last))
      {
        std::abort();
      }
      last = file.time;
    }
  });
  return 0;
}
