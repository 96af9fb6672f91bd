// Python's view of the kernels of sensing. Sizes are checked here, so that no argument can make a
// kernel read or write outside its arrays.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "depth_image.hpp"
#include "given.hpp"

namespace nb = nanobind;
using namespace circumspect;

namespace {

using Depth = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Mask = nb::ndarray<const bool, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using OutMask = nb::ndarray<bool, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Means = nb::ndarray<float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Counts = nb::ndarray<int32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Pose = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Noises = std::tuple<float, float, float, float>;
using Cells = nb::ndarray<nb::numpy, int32_t, nb::ndim<1>>;
using Sums = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;

constexpr std::size_t kMostCells = std::size_t(1) << 26;

void require(bool fulfilled, const char* message) {
  if (!fulfilled) throw std::invalid_argument(message);
}

template <typename Array>
void require_size(const Array& array, const Depth& depth) {
  require(array.shape(0) == depth.shape(0) && array.shape(1) == depth.shape(1),
          "an array of the image's size");
}

Size size_of(const Depth& depth) { return {depth.shape(0), depth.shape(1)}; }

Noise noise_of(const Noises& values) {
  const auto [a, b, c, step] = values;
  return {a, b, c, step};
}

void means(Depth depth, std::optional<Mask> mask, std::size_t block, float jump, Means mean,
           Counts counts) {
  require(block >= 1 && block <= 4096, "block");
  const std::size_t rows = (depth.shape(0) + block - 1) / block;
  const std::size_t columns = (depth.shape(1) + block - 1) / block;
  require(mean.shape(0) == rows && mean.shape(1) == columns && counts.shape(0) == rows &&
              counts.shape(1) == columns,
          "one mean and count a block");
  if (mask) require_size(*mask, depth);
  nb::gil_scoped_release release;
  block_means(depth.data(), mask ? mask->data() : nullptr, size_of(depth), block, jump, mean.data(),
              counts.data());
}

void continuous_pixels(Depth depth, Noises noise, float spreads, float slope, OutMask out) {
  require_size(out, depth);
  nb::gil_scoped_release release;
  continuous(depth.data(), size_of(depth), noise_of(noise), spreads, slope, out.data());
}

void above(Depth depth, std::tuple<float, float, float, float> up,
           std::tuple<float, float, float, float> camera, Noises noise, float margin, float sigmas,
           float farthest, OutMask mask) {
  require_size(mask, depth);
  const auto [x, y, z, height] = up;
  const auto [fx, fy, cx, cy] = camera;
  nb::gil_scoped_release release;
  keep_above(depth.data(), size_of(depth), {x, y, z, height, fx, fy, cx, cy}, noise_of(noise),
             margin, sigmas, farthest, mask.data());
}

nb::tuple cells(Depth depth, Mask mask, std::tuple<double, double, double, double> camera,
                Pose pose, double cell, std::size_t block) {
  require_size(mask, depth);
  require(block >= 1 && block <= 4096, "block");
  require(cell >= 1e-3 && cell <= 1e3, "cell");
  const auto [fx, fy, cx, cy] = camera;
  const double values[4] = {fx, fy, cx, cy};
  PlanCells found;
  {
    nb::gil_scoped_release release;
    found = plan_cells(depth.data(), mask.data(), size_of(depth), values, pose.data(), cell,
                       kMostCells, block);
  }
  const std::size_t blocks = found.cell.size(), cells = found.counts.size();
  return nb::make_tuple(given<Cells>(std::move(found.cell), {blocks}),
                        given<Sums>(std::move(found.counts), {cells}), found.low_x, found.low_y,
                        found.rows, found.columns);
}

void keep(nb::ndarray<const int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> cell,
          nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu> wanted, OutMask mask,
          std::size_t block) {
  require(block >= 1 && block <= 4096, "block");
  const Size size{mask.shape(0), mask.shape(1)};
  require(masked_blocks(mask.data(), size, block) == cell.shape(0), "one cell a masked block");
  for (std::size_t n = 0; n < cell.shape(0); ++n) {
    require(cell.data()[n] >= 0 && std::size_t(cell.data()[n]) < wanted.shape(0), "known cells");
  }
  nb::gil_scoped_release release;
  keep_cells(cell.data(), wanted.data(), size, block, mask.data());
}

}  // namespace

NB_MODULE(_native, m) {
  using namespace nb::literals;
  m.doc() = "Native kernels of sensing.";
  // Outputs are never converted: what is written to a copy would be lost.
  m.def("block_means", &means, "depth"_a, "mask"_a.none(), "block"_a, "jump"_a,
        "mean"_a.noconvert(), "counts"_a.noconvert());
  m.def("continuous", &continuous_pixels, "depth"_a, "noise"_a, "spreads"_a, "slope"_a,
        "out"_a.noconvert());
  m.def("keep_above", &above, "depth"_a, "up"_a, "camera"_a, "noise"_a, "margin"_a, "sigmas"_a,
        "farthest"_a, "mask"_a.noconvert());
  m.def("keep_cells", &keep, "cell"_a, "wanted"_a, "mask"_a.noconvert(), "block"_a = 1);
  m.def("plan_cells", &cells, "depth"_a, "mask"_a, "camera"_a, "pose"_a, "cell"_a, "block"_a = 1);
}
