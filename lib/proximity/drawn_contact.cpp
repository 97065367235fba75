#include "proximity/drawn_contact.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "propagate/drawn_leg.h"

namespace surveymc::proximity {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kChunk = 8;

/// How far an arc of this length may lie from its chord: length dogleg / 8, with the dogleg of the tangents' chord.
double sagitta_of(double length, const Vector3d& t1, const Vector3d& t2) {
  const double q2 = (t2 - t1).squaredNorm();
  return std::abs(length) * std::sqrt(q2) * (1 + 0.125 * q2) / 8;
}

Vector3d arc_displacement(double length, const Vector3d& t1, const Vector3d& t2) {
  const double s = (t2 - t1).squaredNorm() / 4;
  return 0.5 * length * propagate::ratio_factor_of_leg(s) * (t1 + t2);
}

/// A piece of a leg.
struct Piece {
  Vector3d p1, p2, t1, t2, residual;  ///< residual: displacement of the end that is not the arc's, linear along it
  double length, sagitta, from, to;   ///< shares of the leg
};

Piece whole_leg(const DrawnPath& path, std::size_t leg) {
  Piece x{path.p(leg), path.p(leg + 1), path.t(leg), path.t(leg + 1), {}, path.length[leg + 1], 0, 0, 1};
  x.residual = x.p2 - x.p1 - arc_displacement(x.length, x.t1, x.t2);
  const double q2 = (x.t2 - x.t1).squaredNorm();
  x.sagitta = sagitta_of(x.length, x.t1, x.t2) + 0.05 * q2 * x.residual.norm();
  return x;
}

void halve(const Piece& x, Piece& a, Piece& b) {
  const Vector3d t = (x.t1 + x.t2).normalized();
  const Vector3d middle = x.p1 + arc_displacement(x.length / 2, x.t1, t) + x.residual / 2;
  const double share = (x.from + x.to) / 2, q2 = (t - x.t1).squaredNorm();
  const double sagitta = sagitta_of(x.length / 2, x.t1, t) + 0.05 * q2 * x.residual.norm() / 2;
  a = {x.p1, middle, x.t1, t, x.residual / 2, x.length / 2, sagitta, x.from, share};
  b = {middle, x.p2, t, x.t2, x.residual / 2, x.length / 2, sagitta, share, x.to};
}

/// Distance of two segments, and the shares of both where it is (Ericson 2005, 5.1.9).
double segment_distance(const Vector3d& p1, const Vector3d& q1, const Vector3d& p2, const Vector3d& q2, double& s,
                        double& t) {
  const Vector3d d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r);
  const auto clamp = [](double x) { return std::clamp(x, 0.0, 1.0); };
  if (a <= 0 && e <= 0) {
    s = t = 0;
  } else if (a <= 0) {
    s = 0;
    t = clamp(f / e);
  } else {
    const double c = d1.dot(r);
    if (e <= 0) {
      t = 0;
      s = clamp(-c / a);
    } else {
      const double b = d1.dot(d2), denominator = a * e - b * b;
      s = denominator > 0 ? clamp((b * f - c * e) / denominator) : 0;
      t = (b * s + f) / e;
      if (t < 0) {
        t = 0;
        s = clamp(-c / a);
      } else if (t > 1) {
        t = 1;
        s = clamp((b - c) / a);
      }
    }
  }
  return (p1 + d1 * s - p2 - d2 * t).norm();
}

/// An upper bound of whole_leg().sagitta: a residual is no longer than chord and arc together.
double most_sagitta(const DrawnPath& path, std::size_t leg) {
  const double q2 = (path.t(leg + 1) - path.t(leg)).squaredNorm(), arc = std::abs(path.length[leg + 1]);
  const double chord = (path.p(leg + 1) - path.p(leg)).norm();
  return 0.125 * arc * std::sqrt(q2) * (1 + 0.125 * q2) + 0.05 * q2 * (chord + arc);
}

/// Of a leg: arcs of 10,000 km are straight before, and nothing is halved without end.
constexpr double kShortest = 1.0 / (1 << 24);

class Nearest {
 public:
  explicit Nearest(double below) { best.distance = below; }

  void legs(const DrawnPath& reference, std::size_t i, const DrawnPath& offset, std::size_t j) {
    // The chords first: most pairs of legs are left out by them.
    double s = 0, t = 0;
    const double d = segment_distance(reference.p(i), reference.p(i + 1), offset.p(j), offset.p(j + 1), s, t);
    if (d - most_sagitta(reference, i) - most_sagitta(offset, j) >= best.distance) return;
    i_ = i;
    j_ = j;
    pieces(whole_leg(reference, i), whole_leg(offset, j));
  }

  Contact best;

 private:
  void pieces(const Piece& a, const Piece& b) {
    double s = 0, t = 0;
    const double d = segment_distance(a.p1, a.p2, b.p1, b.p2, s, t), error = a.sagitta + b.sagitta;
    if (!(d - error < best.distance)) return;  // a path that is not finite touches nothing
    if (error < kContactError || std::min(a.to - a.from, b.to - b.from) < kShortest) {
      best = {std::min(d, best.distance), i_, j_, a.from + s * (a.to - a.from), b.from + t * (b.to - b.from)};
      return;
    }
    Piece x, y;
    if (a.sagitta >= b.sagitta) {
      halve(a, x, y);
      pieces(s <= 0.5 ? x : y, b);
      pieces(s <= 0.5 ? y : x, b);
    } else {
      halve(b, x, y);
      pieces(a, t <= 0.5 ? x : y);
      pieces(a, t <= 0.5 ? y : x);
    }
  }
  std::size_t i_ = 0, j_ = 0;
};

/// An upper bound of sqrt(q2) without a root: tangent at q = 0.05, a dogleg of three degrees.
double root_bound(double q2) { return 10 * q2 + 0.025; }

void set_spheres(const DrawnPath& path, std::size_t first, LegSpheres& s) {
  const std::size_t legs = path.stations() - 1 - first;
  s.x.resize(legs), s.y.resize(legs), s.z.resize(legs), s.radius.resize(legs);
  const double *px = path.x.data() + first, *py = path.y.data() + first, *pz = path.z.data() + first,
               *tx = path.tx.data() + first, *ty = path.ty.data() + first, *tz = path.tz.data() + first,
               *length = path.length.data() + first;
  double *x = s.x.data(), *y = s.y.data(), *z = s.z.data(), *radius = s.radius.data();
  for (std::size_t k = 0; k < legs; ++k) {
    const double dx = px[k + 1] - px[k], dy = py[k + 1] - py[k], dz = pz[k + 1] - pz[k];
    const double ux = tx[k + 1] - tx[k], uy = ty[k + 1] - ty[k], uz = tz[k + 1] - tz[k];
    x[k] = 0.5 * (px[k + 1] + px[k]), y[k] = 0.5 * (py[k + 1] + py[k]), z[k] = 0.5 * (pz[k + 1] + pz[k]);
    const double q2 = ux * ux + uy * uy + uz * uz, chord = std::sqrt(dx * dx + dy * dy + dz * dz);
    const double arc = std::abs(length[k + 1]);
    // What whole_leg() takes as sagitta is less: a residual is no longer than chord and arc together.
    radius[k] = 0.5 * chord + 0.125 * arc * root_bound(q2) * (1 + 0.125 * q2) + 0.05 * q2 * (chord + arc);
  }
  s.cx.clear(), s.cy.clear(), s.cz.clear(), s.cradius.clear();
  for (std::size_t c = 0; c < legs; c += kChunk) {
    const std::size_t end = std::min(c + kChunk, legs);
    const double mx = 0.5 * (px[c] + px[end]), my = 0.5 * (py[c] + py[end]), mz = 0.5 * (pz[c] + pz[end]);
    double square = 0, most = 0;  // middles and radii apart: one root for all
    for (std::size_t k = c; k < end; ++k) {
      const double dx = x[k] - mx, dy = y[k] - my, dz = z[k] - mz;
      square = std::max(square, dx * dx + dy * dy + dz * dz);
      most = std::max(most, radius[k]);
    }
    s.cx.push_back(mx), s.cy.push_back(my), s.cz.push_back(mz), s.cradius.push_back(std::sqrt(square) + most);
  }
}

}  // namespace

void DrawnPath::resize(std::size_t stations) {
  for (std::vector<double>* v : {&x, &y, &z, &tx, &ty, &tz, &length}) v->resize(stations);
}

void DrawnPath::set(std::size_t k, const Vector3d& place, const Vector3d& tangent, double leg) {
  x[k] = place.x(), y[k] = place.y(), z[k] = place.z();
  tx[k] = tangent.x(), ty[k] = tangent.y(), tz[k] = tangent.z();
  length[k] = leg;
}

Contact nearest_contact(const DrawnPath& reference, std::size_t first_reference, const DrawnPath& offset,
                        std::size_t first_offset, double below, ContactScratch& scratch) {
  LegSpheres &a = scratch.reference, &b = scratch.offset;
  set_spheres(reference, first_reference, a);
  set_spheres(offset, first_offset, b);
  using Candidate = ContactScratch::Candidate;
  std::vector<Candidate>& candidates = scratch.candidates;
  candidates.clear();
  double upper = below;  // whatever two spheres hold is nearer than this: nothing farther counts
  for (std::size_t c = 0; c < a.cx.size() && below == kInfinity; ++c)
    for (std::size_t d = 0; d < b.cx.size(); ++d)
      upper = std::min(
          upper, std::hypot(a.cx[c] - b.cx[d], a.cy[c] - b.cy[d], a.cz[c] - b.cz[d]) + a.cradius[c] + b.cradius[d]);
  for (std::size_t c = 0; c < a.cx.size(); ++c)
    for (std::size_t d = 0; d < b.cx.size(); ++d) {
      const double dx = a.cx[c] - b.cx[d], dy = a.cy[c] - b.cy[d], dz = a.cz[c] - b.cz[d];
      const double reach = a.cradius[c] + b.cradius[d] + upper;
      if (dx * dx + dy * dy + dz * dz >= reach * reach) continue;
      const std::size_t i_end = std::min((c + 1) * kChunk, a.x.size()), j_begin = d * kChunk,
                        j_end = std::min(j_begin + kChunk, b.x.size());
      for (std::size_t i = c * kChunk; i < i_end; ++i) {
        double square[kChunk];
        for (std::size_t j = j_begin; j < j_end; ++j) {
          const double x = a.x[i] - b.x[j], y = a.y[i] - b.y[j], z = a.z[i] - b.z[j];
          square[j - j_begin] = x * x + y * y + z * z;
        }
        for (std::size_t j = j_begin; j < j_end; ++j) {
          const double radii = a.radius[i] + b.radius[j], most = upper + radii;
          if (square[j - j_begin] >= most * most) continue;
          const double middles = std::sqrt(square[j - j_begin]);
          candidates.push_back({middles - radii, i, j});
          upper = std::min(upper, middles + radii);
        }
      }
    }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& x, const Candidate& y) {
    return x.bound != y.bound ? x.bound < y.bound : std::pair(x.i, x.j) < std::pair(y.i, y.j);
  });
  Nearest nearest(below);
  for (const Candidate& c : candidates) {
    if (c.bound >= nearest.best.distance) break;
    nearest.legs(reference, first_reference + c.i, offset, first_offset + c.j);
  }
  return nearest.best;
}

}  // namespace surveymc::proximity
