// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/HOPRFile.h"

#include <vtk_hdf5.h>

#include <cerrno>

#include <unistd.h>

namespace bsv
{

namespace
{

/// Something of the HDF5 library that has to be closed.
class Handle
{
public:
  Handle(hid_t id, herr_t (*close)(hid_t))
    : Id(id)
    , Close(close)
  {
  }
  ~Handle()
  {
    if (this->Id >= 0)
    {
      this->Close(this->Id);
    }
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return this->Id; }

private:
  hid_t Id;
  herr_t (*Close)(hid_t);
};

/// Types in the file and in memory. To be closed.
hid_t typeInFile(HDF5Type type)
{
  const hid_t known = H5Tcopy(type == HDF5Type::Integer ? H5T_STD_I32LE
      : type == HDF5Type::Real                          ? H5T_IEEE_F64LE
                                                        : H5T_C_S1);
  if (type == HDF5Type::Text)
  {
    H5Tset_size(known, HOPRLibrary::TextLength);
    H5Tset_strpad(known, H5T_STR_SPACEPAD);
  }
  return known;
}
hid_t typeInMemory(HDF5Type type)
{
  return type == HDF5Type::Integer ? H5Tcopy(H5T_NATIVE_INT)
    : type == HDF5Type::Real       ? H5Tcopy(H5T_NATIVE_DOUBLE)
                                   : typeInFile(type);
}

} // namespace

HOPRLibrary::HOPRLibrary(const std::string& path, const std::string& target)
  : Path(path)
  , Target(target)
{
  H5E_auto2_t report = nullptr;
  void* data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &report, &data);
  // Errors become exceptions here, and nothing is printed.
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  this->Restore = [=] { H5Eset_auto2(H5E_DEFAULT, report, data); };
  // HDF5 2 notes the time of day also for the root group.
  const Handle properties(H5Pcreate(H5P_FILE_CREATE), &H5Pclose);
  H5Pset_obj_track_times(properties, false);
  this->File = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, properties, H5P_DEFAULT);
  if (this->File < 0)
  {
    this->Restore();
    throw FileError("Cannot create '" + target + "'", errno);
  }
}

HOPRLibrary::~HOPRLibrary()
{
  if (this->File >= 0)
  {
    // Where it works in the process of others it has to let go of the file, for which it needs room.
    (void)!::truncate(this->Path.c_str(), 0);
    H5Fclose(this->File);
  }
  this->Restore();
}

std::string HOPRLibrary::close()
{
  this->check(H5Fflush(this->File, H5F_SCOPE_GLOBAL), "the end");
  const hid_t id = this->File;
  this->File = -1;
  this->check(H5Fclose(id), "the end");
  return {};
}

void HOPRLibrary::check(std::int64_t status, const std::string& what) const
{
  if (status < 0)
  {
    throw FileError("Cannot write " + what + " to '" + this->Target + "'", errno);
  }
}

void HOPRLibrary::number(const std::string& name, double value)
{
  this->attribute(name, HDF5Type::Real, &value);
}

void HOPRLibrary::count(const std::string& name, int value)
{
  this->attribute(name, HDF5Type::Integer, &value);
}

void HOPRLibrary::create(const std::string& name, HDF5Type type, Index rows, int columns)
{
  const hsize_t size[2] = { static_cast<hsize_t>(rows), static_cast<hsize_t>(columns) };
  const Handle space(H5Screate_simple(columns > 0 ? 2 : 1, size, nullptr), &H5Sclose);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose);
  // The time of day would make equal meshes to different files.
  this->check(H5Pset_obj_track_times(properties, false), name);
  const Handle kind(typeInFile(type), &H5Tclose);
  const Handle set(H5Dcreate2(this->File, name.c_str(), kind, space, H5P_DEFAULT, properties, H5P_DEFAULT), &H5Dclose);
  this->check(set, name);
}

void HOPRLibrary::integers(
  const std::string& name, Index first, Index count, int columns, const std::vector<int>& values)
{
  this->rows(name, HDF5Type::Integer, first, count, columns, values.data());
}

void HOPRLibrary::reals(
  const std::string& name, Index first, Index count, int columns, const std::vector<double>& values)
{
  this->rows(name, HDF5Type::Real, first, count, columns, values.data());
}

void HOPRLibrary::texts(const std::string& name, Index first, Index count, int columns, const std::vector<char>& values)
{
  this->rows(name, HDF5Type::Text, first, count, columns, values.data());
}

void HOPRLibrary::rows(
  const std::string& name, HDF5Type type, Index first, Index count, int columns, const void* values)
{
  if (count == 0)
  {
    return;
  }
  const hsize_t start[2] = { static_cast<hsize_t>(first), 0 };
  const hsize_t size[2] = { static_cast<hsize_t>(count), static_cast<hsize_t>(columns) };
  const Handle set(H5Dopen2(this->File, name.c_str(), H5P_DEFAULT), &H5Dclose);
  const Handle space(H5Dget_space(set), &H5Sclose);
  const Handle memory(H5Screate_simple(columns > 0 ? 2 : 1, size, nullptr), &H5Sclose);
  const Handle kind(typeInMemory(type), &H5Tclose);
  this->check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, size, nullptr), name);
  this->check(H5Dwrite(set, kind, memory, space, H5P_DEFAULT, values), name);
}

void HOPRLibrary::attribute(const std::string& name, HDF5Type type, const void* value)
{
  const hsize_t one = 1;
  const Handle space(H5Screate_simple(1, &one, nullptr), &H5Sclose);
  const Handle kind(typeInMemory(type), &H5Tclose);
  const Handle attribute(H5Acreate2(this->File, name.c_str(), kind, space, H5P_DEFAULT, H5P_DEFAULT), &H5Aclose);
  this->check(H5Awrite(attribute, kind, value), name);
}

} // namespace bsv
