#include "plane_fits.hpp"

#include <cmath>
#include <utility>

namespace circumspect {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

constexpr int kSweeps = 12;          // a few are enough; each squares what is left off the diagonal
constexpr double kVanished = 1e-32;  // squared, against the diagonal

// One rotation of Jacobi's method (Golub and Van Loan, "Matrix computations", section 8.5) that
// makes a[p][q] zero.
void rotate(Matrix& a, Matrix& v, int p, int q) {
  if (a[p][q] == 0.0) return;
  const double tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  const double t = (tau >= 0 ? 1.0 : -1.0) / (std::fabs(tau) + std::sqrt(1.0 + tau * tau));
  const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
  const int r = 3 - p - q;
  const double apq = a[p][q], arp = a[r][p], arq = a[r][q];
  a[p][p] -= t * apq;
  a[q][q] += t * apq;
  a[p][q] = a[q][p] = 0.0;
  a[r][p] = a[p][r] = c * arp - s * arq;
  a[r][q] = a[q][r] = s * arp + c * arq;
  for (int k = 0; k < 3; ++k) {
    const double vkp = v[k][p], vkq = v[k][q];
    v[k][p] = c * vkp - s * vkq;
    v[k][q] = s * vkp + c * vkq;
  }
}

}  // namespace

PlaneFit plane_fit(const double* points_xyz, const int64_t* numbers, std::size_t count) {
  double mean[3] = {0.0, 0.0, 0.0};
  for (std::size_t n = 0; n < count; ++n) {
    for (int k = 0; k < 3; ++k) mean[k] += points_xyz[3 * numbers[n] + k];
  }
  for (double& value : mean) value /= static_cast<double>(count);
  Matrix a{}, v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t n = 0; n < count; ++n) {
    double away[3];
    for (int k = 0; k < 3; ++k) away[k] = points_xyz[3 * numbers[n] + k] - mean[k];
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) a[i][j] += away[i] * away[j];
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) a[j][i] = a[i][j] /= static_cast<double>(count);
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
    const double on = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
    if (off <= kVanished * on) break;
    rotate(a, v, 0, 1);
    rotate(a, v, 0, 2);
    rotate(a, v, 1, 2);
  }
  int order[3] = {0, 1, 2};
  for (const auto& [i, j] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 1}}) {
    if (a[order[j]][order[j]] < a[order[i]][order[i]]) std::swap(order[i], order[j]);
  }
  PlaneFit fit;
  for (int k = 0; k < 3; ++k) {
    fit.normal[k] = v[k][order[0]];
    fit.variances[k] = a[order[k]][order[k]];
  }
  return fit;
}

}  // namespace circumspect
