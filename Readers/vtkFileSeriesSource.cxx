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

#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <regex>

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
  static const std::regex name(R"re("name"\s*:\s*"((?:[^"\\]|\\.)*)")re");
  static const std::regex time(R"re("time"\s*:\s*([-+0-9.eE]+))re");
  std::vector<Listed> files;
  // Every entry is an object without objects in it.
  const std::size_t start = text.find("\"files\"");
  for (std::size_t at = start; at != std::string::npos;)
  {
    const std::size_t begin = text.find('{', at);
    const std::size_t end = begin == std::string::npos ? begin : text.find('}', begin);
    if (end == std::string::npos)
    {
      break;
    }
    at = end;
    const std::string entry = text.substr(begin, end - begin);
    std::smatch found;
    if (!std::regex_search(entry, found, name))
    {
      throw bsv::Error(fileName + ": entry " + std::to_string(files.size()) + " of the list has no \"name\"");
    }
    std::string file;
    const std::string quoted = found[1];
    for (std::size_t n = 0; n < quoted.size(); ++n)
    {
      n += quoted[n] == '\\' ? 1 : 0;
      file += quoted[n];
    }
    double value = static_cast<double>(files.size());
    if (std::regex_search(entry, found, time))
    {
      value = std::strtod(found[1].str().c_str(), nullptr);
    }
    if (!folder.empty() && !vtksys::SystemTools::FileIsFullPath(file))
    {
      file.insert(0, folder + "/");
    }
    if (!files.empty() && !(value > files.back().time))
    {
      throw bsv::Error(fileName + ": entry " + std::to_string(files.size()) + " of the list, '" + file +
        "', is not later than the one before it");
    }
    files.push_back({ file, value });
  }
  if (files.empty())
  {
    throw bsv::Error(
      fileName + ": the list names no files; expected is {\"files\": [{\"name\": .., \"time\": ..}, ..]}");
  }
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
