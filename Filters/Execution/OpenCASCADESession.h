// SPDX-License-Identifier: BSD-3-Clause
/// @file OpenCASCADESession.h
/// The only way to use OpenCASCADE's file formats: one at a time, silent, with its global settings restored. Only files
/// that are compiled with OpenCASCADE include this.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>

#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace bsv
{

/// One for all libraries of a process.
BSPLINEVOLUMEFILTERS_EXPORT inline std::mutex& openCASCADEGuard()
{
  static std::mutex guard;
  return guard;
}

class OpenCASCADESession
{
public:
  OpenCASCADESession()
    : Lock(openCASCADEGuard())
  {
    this->Printers = Message::DefaultMessenger()->Printers();
    Message::DefaultMessenger()->ChangePrinters().Clear();
  }
  ~OpenCASCADESession()
  {
    for (auto at = this->Restore.rbegin(); at != this->Restore.rend(); ++at)
    {
      (*at)();
    }
    Message::DefaultMessenger()->ChangePrinters() = this->Printers;
  }
  OpenCASCADESession(const OpenCASCADESession&) = delete;
  OpenCASCADESession& operator=(const OpenCASCADESession&) = delete;

  /// A setting that exists once the format's controller is initialised.
  void set(const char* name, int value)
  {
    const int before = Interface_Static::IVal(name);
    this->Restore.push_back([=] { Interface_Static::SetIVal(name, before); });
    Interface_Static::SetIVal(name, value);
  }
  void set(const char* name, const char* value)
  {
    const char* text = Interface_Static::CVal(name);
    const std::string before = text ? text : "";
    this->Restore.push_back([=] { Interface_Static::SetCVal(name, before.c_str()); });
    Interface_Static::SetCVal(name, value);
  }
  /// What is done at the end.
  void finally(const std::function<void()>& action) { this->Restore.push_back(action); }

private:
  std::lock_guard<std::mutex> Lock;
  Message_SequenceOfPrinters Printers;
  std::vector<std::function<void()>> Restore;
};

} // namespace bsv
