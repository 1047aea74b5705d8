// SPDX-License-Identifier: BSD-3-Clause
/// @file Messages.h
/// What an algorithm says in a test.
#pragma once

#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>

#include <string>
#include <vector>

namespace bsvtest
{

/// Collects errors and warnings of an algorithm, instead of on the console, while it exists.
class Messages
{
public:
  Messages(vtkAlgorithm* algorithm, std::vector<std::string>& errors, std::vector<std::string>& warnings)
    : Algorithm(algorithm)
  {
    const auto collect = [](vtkObject*, unsigned long, void* list, void* text) {
      static_cast<std::vector<std::string>*>(list)->emplace_back(static_cast<const char*>(text));
    };
    this->OnError->SetCallback(collect);
    this->OnError->SetClientData(&errors);
    this->OnWarning->SetCallback(collect);
    this->OnWarning->SetClientData(&warnings);
    algorithm->AddObserver(vtkCommand::ErrorEvent, this->OnError);
    algorithm->AddObserver(vtkCommand::WarningEvent, this->OnWarning);
  }
  ~Messages()
  {
    this->Algorithm->RemoveObserver(this->OnError);
    this->Algorithm->RemoveObserver(this->OnWarning);
  }
  Messages(const Messages&) = delete;
  void operator=(const Messages&) = delete;

private:
  vtkAlgorithm* Algorithm;
  vtkNew<vtkCallbackCommand> OnError;
  vtkNew<vtkCallbackCommand> OnWarning;
};

} // namespace bsvtest
