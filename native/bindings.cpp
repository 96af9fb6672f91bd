// Python's view of the kernels. Everything is checked here again, so that no argument can make
// a kernel read or write outside its arrays; the messages users see are made in Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "box.hpp"
#include "box_beams.hpp"
#include "coaxial.hpp"
#include "coaxial_trace.hpp"
#include "cylinder.hpp"
#include "cylinder_beams.hpp"
#include "fit.hpp"
#include "hits.hpp"
#include "trace.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

template <typename T>
using Points = nb::ndarray<const T, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using States = nb::ndarray<uint8_t, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Batch = nb::ndarray<uint8_t, nb::ndim<4>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<int32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

constexpr int32_t kMostCellsAlong = 4096;
constexpr std::size_t kMostCells = std::size_t(1) << 28;

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

Shape checked_shape(std::tuple<int32_t, int32_t, int32_t> cells) {
  const auto [i, j, k] = cells;
  for (const int32_t n : {i, j, k}) require(n >= 1 && n <= kMostCellsAlong, "cells along an axis");
  const Shape shape{i, j, k};
  require(shape.cells() <= kMostCells, "number of cells");
  return shape;
}

void require_length(double length, const char* message) {
  require(length >= 1e-50 && length <= kLargestCoordinate, message);
}

void require_centre(double x, double y, double z) {
  for (const double c : {x, y, z}) require(std::fabs(c) <= kLargestCoordinate, "centre");
}

Cylinder make_cylinder(std::tuple<int32_t, int32_t, int32_t> cells, double radius,
                       double half_height, std::tuple<double, double, double> centre_xyz,
                       double azimuth_offset) {
  const auto [x, y, z] = centre_xyz;
  require_length(radius, "radius");
  require_length(half_height, "half height");
  require_centre(x, y, z);
  require(azimuth_offset >= 0.0 && azimuth_offset < 6.2831853071795872, "azimuth offset");
  return Cylinder(checked_shape(cells), radius, half_height, x, y, z, azimuth_offset);
}

Box make_box(std::tuple<int32_t, int32_t, int32_t> cells, double half_width,
             std::tuple<double, double, double> centre_xyz, double yaw) {
  const auto [x, y, z] = centre_xyz;
  require_length(half_width, "half width");
  require_centre(x, y, z);
  require(std::isfinite(yaw), "yaw");
  return Box{checked_shape(cells), half_width, x, y, z, std::cos(yaw), std::sin(yaw)};
}

template <typename Array>
void require_cells(const Array& states, std::size_t first, const Shape& shape) {
  require(states.shape(first) == std::size_t(shape.i) &&
              states.shape(first + 1) == std::size_t(shape.j) &&
              states.shape(first + 2) == std::size_t(shape.k),
          "the array of states has another shape than the grid");
}

template <typename Grid, typename T>
int64_t hits(const Grid& grid, Points<T> points_xyz, States states, uint8_t value,
             std::size_t threads) {
  require_cells(states, 0, grid.shape);
  nb::gil_scoped_release release;
  return mark_hits(grid, points_xyz.data(), points_xyz.shape(0), value, states.data(), threads);
}

template <typename Grid, typename T>
int64_t indices(const Grid& grid, Points<T> points_xyz, Indices out, std::size_t threads) {
  require(out.shape(0) == points_xyz.shape(0), "as many rows of indices as points");
  nb::gil_scoped_release release;
  return write_indices(grid, points_xyz.data(), points_xyz.shape(0), out.data(), threads);
}

// One cloud a grid; returns the number of the first cloud with unusable points, or -1.
template <typename Grid, typename T>
int64_t hits_batch(const std::vector<const Grid*>& grids, const std::vector<Points<T>>& clouds,
                   Batch states, uint8_t value, std::size_t threads) {
  require(grids.size() == clouds.size() && states.shape(0) == clouds.size(),
          "one grid and one output a cloud");
  for (const Grid* grid : grids) {
    require(grid != nullptr, "a grid");
    require_cells(states, 1, grid->shape);
  }
  nb::gil_scoped_release release;
  std::atomic<int64_t> first_bad{int64_t(clouds.size())};
  parallel_for(clouds.size(), threads, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const std::size_t cells = grids[n]->shape.cells();
      const int64_t bad = mark_hits(*grids[n], clouds[n].data(), clouds[n].shape(0), value,
                                    states.data() + n * cells, 1);
      int64_t known = first_bad.load();
      while (bad > 0 && int64_t(n) < known && !first_bad.compare_exchange_weak(known, int64_t(n))) {
      }
    }
  });
  return first_bad == int64_t(clouds.size()) ? -1 : first_bad.load();
}

// All grids must be of one shape about one axis.
void require_coaxial(const std::vector<const Cylinder*>& grids, const Batch& states) {
  require(!grids.empty() && states.shape(0) == grids.size(), "one output a grid");
  for (const Cylinder* grid : grids) {
    require(grid != nullptr, "a grid");
    require_cells(states, 1, grid->shape);
    require(grid->x == grids[0]->x && grid->y == grids[0]->y, "grids about one axis");
  }
}

template <typename T>
int64_t hits_coaxial(const std::vector<const Cylinder*>& grids, Points<T> points_xyz, double yaw,
                     Batch states, uint8_t value, std::size_t threads) {
  require_coaxial(grids, states);
  require(std::isfinite(yaw), "yaw");
  nb::gil_scoped_release release;
  return mark_coaxial_hits(Coaxial(grids, yaw), points_xyz.data(), points_xyz.shape(0), value,
                           states.data(), threads);
}

template <typename Tracer, typename Grid, typename T>
int64_t passed(const Grid& grid, Points<T> origins_xyz, Points<T> ends_xyz, States states,
               uint8_t value, std::size_t threads) {
  require_cells(states, 0, grid.shape);
  const std::size_t origins = origins_xyz.shape(0), ends = ends_xyz.shape(0);
  require(origins == 1 || origins == ends, "one origin, or as many as ends");
  nb::gil_scoped_release release;
  return mark_passed<Tracer>(grid, origins_xyz.data(), origins, ends_xyz.data(), ends, value,
                             states.data(), threads);
}

template <typename T>
int64_t passed_coaxial(const std::vector<const Cylinder*>& grids, Points<T> origins_xyz,
                       Points<T> ends_xyz, Batch states, uint8_t value, std::size_t threads) {
  require_coaxial(grids, states);
  const std::size_t origins = origins_xyz.shape(0), ends = ends_xyz.shape(0);
  require(origins == 1 || origins == ends, "one origin, or as many as ends");
  nb::gil_scoped_release release;
  return mark_coaxial_passed(grids, origins_xyz.data(), origins, ends_xyz.data(), ends, value,
                             states.data(), threads);
}

template <typename Tracer, typename Grid>
void bind_methods(nb::module_& m, nb::class_<Grid>& grid) {
  using namespace nb::literals;
  // Outputs are never converted: what is written to a copy would be lost.
  const auto states = "states"_a.noconvert(), out = "out"_a.noconvert();
  grid.def("hits", &hits<Grid, double>, "points_xyz"_a, states, "value"_a, "threads"_a)
      .def("hits", &hits<Grid, float>, "points_xyz"_a, states, "value"_a, "threads"_a)
      .def("indices", &indices<Grid, double>, "points_xyz"_a, out, "threads"_a)
      .def("indices", &indices<Grid, float>, "points_xyz"_a, out, "threads"_a)
      .def("passed", &passed<Tracer, Grid, double>, "origins_xyz"_a, "ends_xyz"_a, states,
           "value"_a, "threads"_a)
      .def("passed", &passed<Tracer, Grid, float>, "origins_xyz"_a, "ends_xyz"_a, states, "value"_a,
           "threads"_a);
  m.def("hits_batch", &hits_batch<Grid, double>, "grids"_a, "clouds"_a, states, "value"_a,
        "threads"_a);
  m.def("hits_batch", &hits_batch<Grid, float>, "grids"_a, "clouds"_a, states, "value"_a,
        "threads"_a);
}

using Weights = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Axes = std::tuple<double, double, double>;

Axes axes_of(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

std::tuple<Axes, Axes, Axes> weighted_centre_of(Points<double> points_xyz,
                                                std::optional<Weights> weights) {
  const std::size_t count = points_xyz.shape(0);
  require(count >= 1, "a point");
  require(!weights || weights->shape(0) == count, "as many weights as points");
  nb::gil_scoped_release release;
  const WeightedCentre found =
      weighted_centre(points_xyz.data(), weights ? weights->data() : nullptr, count);
  return {axes_of(found.centre), axes_of(found.low), axes_of(found.high)};
}

std::tuple<double, double, double, double> reach_of(Points<double> points_xyz, Axes centre_xyz,
                                                    double yaw) {
  const auto [x, y, z] = centre_xyz;
  nb::gil_scoped_release release;
  const Reach found =
      reach(points_xyz.data(), points_xyz.shape(0), {x, y, z}, std::cos(yaw), std::sin(yaw));
  return {found.radius, found.x, found.y, found.z};
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native grid kernels.";
  m.attr("MOST_CELLS_ALONG") = kMostCellsAlong;
  m.attr("MOST_CELLS") = kMostCells;

  m.def("weighted_centre", &weighted_centre_of, "points_xyz"_a, "weights"_a.none());
  m.def("reach", &reach_of, "points_xyz"_a, "centre_xyz"_a, "yaw"_a);
  auto cylinder = nb::class_<Cylinder>(m, "Cylinder");
  cylinder.def(nb::new_(&make_cylinder), "shape"_a, "radius"_a, "half_height"_a, "centre_xyz"_a,
               "azimuth_offset"_a);
  bind_methods<CylinderTracer>(m, cylinder);
  const auto states = "states"_a.noconvert();
  m.def("hits_coaxial", &hits_coaxial<double>, "grids"_a, "points_xyz"_a, "yaw"_a, states,
        "value"_a, "threads"_a);
  m.def("hits_coaxial", &hits_coaxial<float>, "grids"_a, "points_xyz"_a, "yaw"_a, states, "value"_a,
        "threads"_a);
  m.def("passed_coaxial", &passed_coaxial<double>, "grids"_a, "origins_xyz"_a, "ends_xyz"_a, states,
        "value"_a, "threads"_a);
  m.def("passed_coaxial", &passed_coaxial<float>, "grids"_a, "origins_xyz"_a, "ends_xyz"_a, states,
        "value"_a, "threads"_a);
  auto box = nb::class_<Box>(m, "Box");
  box.def(nb::new_(&make_box), "shape"_a, "half_width"_a, "centre_xyz"_a, "yaw"_a);
  bind_methods<BoxTracer>(m, box);
}
