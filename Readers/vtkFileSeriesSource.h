// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkFileSeriesSource
 * @brief   superclass of readers whose files can be the time steps of a series
 *
 * Several files are the steps of a series, in the order in which they were added. A file whose name ends in `.series`
 * stands for the files that it lists, with their times, as ParaView writes it (JSON: `{"files": [{"name": "a.xyz",
 * "time": 0.5}, ..]}`, names relative to its folder). The time of a step is
 * - that of the `.series` file, or else
 * - that in the file itself, if it holds any (TimesIn()): each is a step of its own; or else
 * - the place of the file in the series: 0, 1, ..
 *
 * A single file without any time has no time steps. Of all steps that the pipeline does not ask for nothing is read.
 * The step taken is the last one that is not later than the time asked for, or the first one.
 */
#ifndef vtkFileSeriesSource_h
#define vtkFileSeriesSource_h

#include "BSplineVolumeReadersModule.h" // For export macro
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the file names
#include <vector> // For the file names

class BSPLINEVOLUMEREADERS_EXPORT vtkFileSeriesSource : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  vtkTypeMacro(vtkFileSeriesSource, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The file, in place of all others; null or empty for none. GetFileName() gives the first one, or null.
   */
  void SetFileName(const char* fileName);
  const char* GetFileName() const;
  ///@}

  ///@{
  /**
   * The files of a series. GetFileName(index) gives null beyond the last one.
   */
  void AddFileName(const char* fileName);
  void RemoveAllFileNames();
  int GetNumberOfFileNames() const { return static_cast<int>(this->FileNames.size()); }
  const char* GetFileName(int index) const;
  ///@}

protected:
  vtkFileSeriesSource();
  ~vtkFileSeriesSource() override = default;

  /// Tells the times, and that pieces may be asked for: else the pipeline would not execute the later ones.
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

  /// A step of the series.
  struct Step
  {
    std::string file;
    /// Number of the step in the file, from 0.
    int number = 0;
    double time = 0.0;
    /// Whether there are time steps at all.
    bool timed = false;
  };

  /// The times that a file holds, ascending; none by default. Errors are left to the reading of the file: none then.
  virtual std::vector<double> TimesIn(const std::string& fileName);

  /// What the pipeline asks for. @throws bsv::Error for a `.series` file that is none.
  Step RequestedStep(vtkInformationVector* outputVector);

  /// Gives the output its time.
  static void SetTime(vtkDataObject* output, const Step& step);

  /// The first file of a `.series` file, any other file itself. Never throws.
  static std::string FirstFile(const char* fileName);

  /// Sets the error code of a file that could not be read.
  void SetFileError(const std::string& fileName);

private:
  vtkFileSeriesSource(const vtkFileSeriesSource&) = delete;
  void operator=(const vtkFileSeriesSource&) = delete;

  std::vector<Step> Steps();

  std::vector<std::string> FileNames;
};

#endif
