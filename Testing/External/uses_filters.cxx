// SPDX-License-Identifier: BSD-3-Clause
// Filters in a C++ program: source, conversion and samples.
#include <vtkBSplineVolumeSampler.h>
#include <vtkCatmullClarkToBSplineVolume.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkWingFuselageSource.h>

#include <cstdio>

int main()
{
  vtkNew<vtkWingFuselageSource> source;
  source->SetResolution(3);
  vtkNew<vtkCatmullClarkToBSplineVolume> conversion;
  conversion->SetInputConnection(source->GetOutputPort());
  vtkNew<vtkBSplineVolumeSampler> sampler;
  sampler->SetInputConnection(conversion->GetOutputPort());
  sampler->Update();
  const auto* samples = vtkPartitionedDataSetCollection::SafeDownCast(sampler->GetOutputDataObject(0));
  std::printf("%u blocks\n", samples ? samples->GetNumberOfPartitionedDataSets() : 0U);
  return samples && samples->GetNumberOfPartitionedDataSets() == 79 ? 0 : 1;
}
