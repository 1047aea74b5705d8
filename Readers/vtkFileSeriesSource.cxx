// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFileSeriesSource.h"

#include "Base/Types.h"
#include "Formats/SeriesList.h"

#include "vtkDataObject.h"
#include "vtkErrorCode.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtksys/SystemTools.hxx"

#include <exception>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

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
    if (bsv::isSeriesList(name))
    {
      timed = true;
      for (const bsv::SeriesFile& file : bsv::readSeriesList(name))
      {
        steps.push_back({ file.name, 0, file.time });
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
  if (this->FileNames.size() == 1 && !bsv::isSeriesList(this->FileNames[0]) && !info->Has(Pipeline::TIME_STEPS()))
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
  std::string name = fileName ? fileName : "";
  try
  {
    return bsv::isSeriesList(name) ? bsv::readSeriesList(name).front().name : name;
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
