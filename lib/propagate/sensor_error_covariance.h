#pragma once
/// First-order position covariance of the twelve constant sensor errors (survey/sensor_terms.h), toolface by toolface,
/// and with the toolface averaged out.
///
/// With g and b what the triads read, u = g/G and t the direction of the hole,
///   dt = dt/du (1 - u u')/G dg + dt/db db,  dg_i = ABi + ASi g_i,  db_i = MBi + MSi b_i.
/// These are the toolface-dependent weighting functions of SPE 67616 without inclination and azimuth, so that vertical
/// holes are like any other.
#include <vector>

#include <Eigen/Core>

#include "propagate/tangent_propagation.h"
#include "survey/reference_field.h"
#include "survey/sensor_terms.h"
#include "survey/toolface_plan.h"

namespace surveymc::propagate {

using Matrix3x12d = Eigen::Matrix<double, 3, survey::kSensorTerms>;

/// Derivative of the hole's direction (n, e, v; magnetic north) by the twelve errors, in the units of sensor_terms.h.
/// `gravity_T` in m/s2, `field_T` in nT: noise-free readings.
Matrix3x12d tangent_by_sensor_terms(const survey::Vec3<double>& gravity_T, const survey::Vec3<double>& field_T);

/// Effects of errors with standard deviations `sd` at every station of a survey whose tool is turned by `plan`.
///
/// Where a toolface is drawn, the covariance that follows is the mean over toolfaces: the weights are trigonometric
/// polynomials of the second order in toolface, their constant parts add up along the hole, and the others do so within
/// a slide only (Torkildsen and Bang 2000, appendix E; they call the parts fictive error sources).
std::vector<TangentErrors> sensor_tangent_errors(const survey::Survey& survey, const survey::ReferenceField& field,
                                                 const survey::SensorTermArray& sd, const survey::ToolfacePlan& plan);

/// The two together: covariance of the position at every station.
std::vector<Eigen::Matrix3d> sensor_error_covariances(const survey::Survey& survey, const survey::ReferenceField& field,
                                                      const survey::SensorTermArray& sd,
                                                      const survey::ToolfacePlan& plan, survey::PositionMethod method);

}  // namespace surveymc::propagate
