// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFileSeriesSource.h"

#include "Base/Types.h"
#include "IO/RegularFile.h"

#include "vtkDataObject.h"
#include "vtkErrorCode.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtksys/SystemTools.hxx"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace
{

/// A file of a list, and its time.
struct Listed
{
  std::string file;
  double time;
};

bool isList(const std::string& fileName)
{
  return vtksys::SystemTools::LowerCase(vtksys::SystemTools::GetFilenameLastExtension(fileName)) == ".series";
}

/// Goes through the text of a `.series` file, which is JSON. No recursion, whatever the file holds.
class ListScanner
{
public:
  ListScanner(const std::string& text, std::string where)
    : Text(text)
    , Where(std::move(where))
  {
  }

  [[noreturn]] void fail(const std::string& what) const
  {
    const auto at = this->Text.begin() + static_cast<std::ptrdiff_t>(std::min(this->At, this->Text.size()));
    throw bsv::Error(
      this->Where + ", line " + std::to_string(1 + std::count(this->Text.begin(), at, '\n')) + ": " + what);
  }

  /// Goes behind `word`. @return whether it is there
  bool find(const std::string& word)
  {
    const std::size_t found = this->Text.find(word, this->At);
    this->At = found == std::string::npos ? this->Text.size() : found + word.size();
    return found != std::string::npos;
  }
  /// The next character that is no blank, 0 at the end.
  char next()
  {
    while (this->At < this->Text.size() && std::strchr(" \t\r\n", this->Text[this->At]))
    {
      ++this->At;
    }
    return this->At < this->Text.size() ? this->Text[this->At] : '\0';
  }
  /// Whether `sign` is next, which is then passed.
  bool take(char sign)
  {
    const bool here = this->next() == sign;
    this->At += here ? 1 : 0;
    return here;
  }
  void expect(char sign)
  {
    if (!this->take(sign))
    {
      this->fail(std::string("here should be ") + sign);
    }
  }

  /// A text in quotes.
  std::string text()
  {
    this->expect('"');
    std::string result;
    for (; this->At < this->Text.size() && this->Text[this->At] != '"'; ++this->At)
    {
      if (this->Text[this->At] != '\\')
      {
        result += this->Text[this->At];
        continue;
      }
      const char sign = ++this->At < this->Text.size() ? this->Text[this->At] : '\0';
      static constexpr char Escapes[][2] = { { 'n', '\n' }, { 't', '\t' }, { 'r', '\r' }, { 'b', '\b' },
        { 'f', '\f' } };
      const auto* found =
        std::find_if(std::begin(Escapes), std::end(Escapes), [&](const auto& escape) { return escape[0] == sign; });
      if (sign == 'u')
      {
        this->appendCode(result);
      }
      else
      {
        result += found != std::end(Escapes) ? (*found)[1] : sign;
      }
    }
    this->expect('"');
    return result;
  }
  /// A number, true, false or null.
  std::string word()
  {
    this->next();
    const std::size_t end = std::min(this->Text.find_first_of(" \t\r\n,:[]{}\"", this->At), this->Text.size());
    const std::string result = this->Text.substr(this->At, end - this->At);
    this->At = end;
    return result;
  }

private:
  /// UTF-8 of four hexadecimal digits behind the current place, or of two such codes.
  void appendCode(std::string& result)
  {
    const auto digits = [this] {
      const std::string four = this->Text.substr(this->At + 1, 4);
      if (four.size() != 4 || four.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      {
        this->fail("\\u" + four + " is no character");
      }
      this->At += 4;
      return static_cast<unsigned>(std::stoul(four, nullptr, 16));
    };
    unsigned code = digits();
    if (code >= 0xd800 && code < 0xdc00 && this->Text.compare(this->At + 1, 2, "\\u") == 0)
    {
      this->At += 2;
      code = 0x10000 + ((code - 0xd800) << 10) + (digits() & 0x3ff);
    }
    const int rest = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static constexpr unsigned First[] = { 0, 0xc0, 0xe0, 0xf0 };
    result += static_cast<char>(First[rest] | (code >> (6 * rest)));
    for (int n = rest - 1; n >= 0; --n)
    {
      result += static_cast<char>(0x80 | ((code >> (6 * n)) & 0x3f));
    }
  }

  const std::string& Text;
  std::string Where;
  std::size_t At = 0;
};

/// The files of a `.series` file.
std::vector<Listed> readList(const std::string& fileName)
{
  // A line per step is far below this.
  constexpr std::uintmax_t MostBytes = 1 << 24;
  std::ifstream stream;
  if (bsv::isRegularFile(fileName) && vtksys::SystemTools::FileLength(fileName) <= MostBytes)
  {
    stream.open(fileName, std::ios::binary);
  }
  if (!stream)
  {
    throw bsv::Error(fileName + ": cannot open the list of a series");
  }
  const std::string text{ std::istreambuf_iterator<char>(stream), {} };
  const std::string folder = vtksys::SystemTools::GetFilenamePath(fileName);
  std::vector<Listed> files;
  ListScanner in(text, fileName);
  if (in.find("\"files\""))
  {
    in.expect(':');
    in.expect('[');
    while (in.take(',') || in.next() == '{')
    {
      in.expect('{');
      const std::string entry = "entry " + std::to_string(files.size()) + " of the list";
      Listed listed{ "", static_cast<double>(files.size()) };
      while (!in.take('}'))
      {
        const std::string key = in.text();
        in.expect(':');
        if (in.next() == '"')
        {
          const std::string value = in.text();
          listed.file = key == "name" ? value : listed.file;
        }
        else
        {
          const std::string value = in.word();
          char* end = nullptr;
          const double number = std::strtod(value.c_str(), &end);
          if (key == "time" && (value.empty() || *end != '\0' || !std::isfinite(number)))
          {
            in.fail(entry + ": the time '" + value.substr(0, 40) + "' is no finite number");
          }
          listed.time = key == "time" ? number : listed.time;
        }
        if (!in.take(',') && in.next() != '}')
        {
          in.fail(entry + ": here should be , or }");
        }
      }
      if (listed.file.empty())
      {
        in.fail(entry + " has no \"name\"");
      }
      if (!folder.empty() && !vtksys::SystemTools::FileIsFullPath(listed.file))
      {
        listed.file.insert(0, folder + "/");
      }
      if (isList(listed.file))
      {
        in.fail(entry + " is a list itself, '" + listed.file + "'");
      }
      if (!files.empty() && !(listed.time > files.back().time))
      {
        in.fail(entry + ", '" + listed.file + "', is not later than the one before it");
      }
      files.push_back(listed);
    }
  }
  if (files.empty())
  {
    throw bsv::Error(
      fileName + ": the list names no files; expected is {\"files\": [{\"name\": .., \"time\": ..}, ..]}");
  }
  in.expect(']');
  return files;
}

} // namespace

//------------------------------------------------------------------------------
vtkFileSeriesSource::vtkFileSeriesSource()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
void vtkFileSeriesSource::SetFileName(const char* fileName)
{
  std::vector<std::string> names;
  if (fileName && *fileName)
  {
    names.emplace_back(fileName);
  }
  if (names != this->FileNames)
  {
    this->FileNames = std::move(names);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
const char* vtkFileSeriesSource::GetFileName() const
{
  return this->GetFileName(0);
}

//------------------------------------------------------------------------------
void vtkFileSeriesSource::AddFileName(const char* fileName)
{
  if (fileName && *fileName)
  {
    this->FileNames.emplace_back(fileName);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkFileSeriesSource::RemoveAllFileNames()
{
  if (!this->FileNames.empty())
  {
    this->FileNames.clear();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
const char* vtkFileSeriesSource::GetFileName(int index) const
{
  return index >= 0 && index < this->GetNumberOfFileNames() ? this->FileNames[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
std::vector<double> vtkFileSeriesSource::TimesIn(const std::string&)
{
  return {};
}

//------------------------------------------------------------------------------
std::vector<vtkFileSeriesSource::Step> vtkFileSeriesSource::Steps()
{
  std::vector<Step> steps;
  bool timed = this->FileNames.size() > 1;
  for (const std::string& name : this->FileNames)
  {
    if (isList(name))
    {
      timed = true;
      for (const Listed& file : readList(name))
      {
        steps.push_back({ file.file, 0, file.time });
      }
      continue;
    }
    const std::vector<double> times = this->TimesIn(name);
    timed = timed || !times.empty();
    for (std::size_t n = 0; n < times.size(); ++n)
    {
      steps.push_back({ name, static_cast<int>(n), times[n] });
    }
    if (times.empty())
    {
      steps.push_back({ name, 0, static_cast<double>(steps.size()) });
    }
  }
  // Times that do not follow each other say nothing about the order of the files, which was given.
  for (std::size_t n = 1; n < steps.size(); ++n)
  {
    if (!(steps[n].time > steps[n - 1].time))
    {
      for (std::size_t m = 0; m < steps.size(); ++m)
      {
        steps[m].time = static_cast<double>(m);
      }
      break;
    }
  }
  for (Step& step : steps)
  {
    step.timed = timed;
  }
  return steps;
}

//------------------------------------------------------------------------------
int vtkFileSeriesSource::RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* info = outputVector->GetInformationObject(0);
  info->Set(CAN_HANDLE_PIECE_REQUEST(), 1);
  info->Remove(Pipeline::TIME_STEPS());
  info->Remove(Pipeline::TIME_RANGE());
  try
  {
    std::vector<double> times;
    for (const Step& step : this->Steps())
    {
      if (step.timed)
      {
        times.push_back(step.time);
      }
    }
    if (!times.empty())
    {
      const double range[2] = { times.front(), times.back() };
      info->Set(Pipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
      info->Set(Pipeline::TIME_RANGE(), range, 2);
    }
  }
  catch (const std::exception&)
  {
    // RequestData() says it.
  }
  return 1;
}

//------------------------------------------------------------------------------
vtkFileSeriesSource::Step vtkFileSeriesSource::RequestedStep(vtkInformationVector* outputVector)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* info = outputVector->GetInformationObject(0);
  if (this->FileNames.empty())
  {
    throw bsv::Error("File Name is empty.");
  }
  if (this->FileNames.size() == 1 && !isList(this->FileNames[0]) && !info->Has(Pipeline::TIME_STEPS()))
  {
    return { this->FileNames[0] };
  }
  const std::vector<Step> steps = this->Steps();
  std::size_t n = 0;
  if (info->Has(Pipeline::UPDATE_TIME_STEP()))
  {
    const double wanted = info->Get(Pipeline::UPDATE_TIME_STEP());
    while (n + 1 < steps.size() && steps[n + 1].time <= wanted)
    {
      ++n;
    }
  }
  return steps[n];
}

//------------------------------------------------------------------------------
void vtkFileSeriesSource::SetTime(vtkDataObject* output, const Step& step)
{
  if (step.timed)
  {
    output->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), step.time);
  }
}

//------------------------------------------------------------------------------
std::string vtkFileSeriesSource::FirstFile(const char* fileName)
{
  const std::string name = fileName ? fileName : "";
  try
  {
    return isList(name) ? readList(name).front().file : name;
  }
  catch (const bsv::Error&)
  {
    return name;
  }
}

//------------------------------------------------------------------------------
void vtkFileSeriesSource::SetFileError(const std::string& fileName)
{
  if (this->FileNames.empty())
  {
    this->SetErrorCode(vtkErrorCode::NoFileNameError);
    return;
  }
  // Where it is not known which file of a series it is, it is the first one.
  this->SetErrorCode(vtksys::SystemTools::FileExists(fileName.empty() ? this->FileNames.front() : fileName)
      ? vtkErrorCode::FileFormatError
      : vtkErrorCode::FileNotFoundError);
}

//------------------------------------------------------------------------------
void vtkFileSeriesSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  for (const std::string& name : this->FileNames)
  {
    os << indent << "FileName: " << name << "\n";
  }
}
