// SPDX-License-Identifier: MIT
#include "physics/stepping/runge_kutta.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace skerry {
namespace {

/// Weight of one stage in a sum.
struct Term {
  int stage;
  double weight;
};

// Coefficients of the pair and its interpolant [Hairer, Norsett & Wanner 1993, sec. II.5, II.6 and the
// appendix].
inline constexpr double kNodes[16] = {0,
                                      0.526001519587677318785587544488e-01,
                                      0.789002279381515978178381316732e-01,
                                      0.118350341907227396726757197510,
                                      0.281649658092772603273242802490,
                                      0.333333333333333333333333333333,
                                      0.25,
                                      0.307692307692307692307692307692,
                                      0.651282051282051282051282051282,
                                      0.6,
                                      0.857142857142857142857142857142,
                                      1,
                                      1,
                                      0.1,
                                      0.2,
                                      0.777777777777777777777777777778};
inline constexpr Term kStage2[] = {{0, 5.26001519587677318785587544488e-2}};
inline constexpr Term kStage3[] = {{0, 1.97250569845378994544595329183e-2},
                                   {1, 5.91751709536136983633785987549e-2}};
inline constexpr Term kStage4[] = {{0, 2.95875854768068491816892993775e-2},
                                   {2, 8.87627564304205475450678981324e-2}};
inline constexpr Term kStage5[] = {{0, 2.41365134159266685502369798665e-1},
                                   {2, -8.84549479328286085344864962717e-1},
                                   {3, 9.24834003261792003115737966543e-1}};
inline constexpr Term kStage6[] = {{0, 3.7037037037037037037037037037e-2},
                                   {3, 1.70828608729473871279604482173e-1},
                                   {4, 1.25467687566822425016691814123e-1}};
inline constexpr Term kStage7[] = {{0, 3.7109375e-2},
                                   {3, 1.70252211019544039314978060272e-1},
                                   {4, 6.02165389804559606850219397283e-2},
                                   {5, -1.7578125e-2}};
inline constexpr Term kStage8[] = {{0, 3.70920001185047927108779319836e-2},
                                   {3, 1.70383925712239993810214054705e-1},
                                   {4, 1.07262030446373284651809199168e-1},
                                   {5, -1.53194377486244017527936158236e-2},
                                   {6, 8.27378916381402288758473766002e-3}};
inline constexpr Term kStage9[] = {
    {0, 6.24110958716075717114429577812e-1},  {3, -3.36089262944694129406857109825},
    {4, -8.68219346841726006818189891453e-1}, {5, 2.75920996994467083049415600797e+1},
    {6, 2.01540675504778934086186788979e+1},  {7, -4.34898841810699588477366255144e+1}};
inline constexpr Term kStage10[] = {
    {0, 4.77662536438264365890433908527e-1},  {3, -2.48811461997166764192642586468},
    {4, -5.90290826836842996371446475743e-1}, {5, 2.12300514481811942347288949897e+1},
    {6, 1.52792336328824235832596922938e+1},  {7, -3.32882109689848629194453265587e+1},
    {8, -2.03312017085086261358222928593e-2}};
inline constexpr Term kStage11[] = {
    {0, -9.3714243008598732571704021658e-1},  {3, 5.18637242884406370830023853209},
    {4, 1.09143734899672957818500254654},     {5, -8.14978701074692612513997267357},
    {6, -1.85200656599969598641566180701e+1}, {7, 2.27394870993505042818970056734e+1},
    {8, 2.49360555267965238987089396762},     {9, -3.0467644718982195003823669022}};
inline constexpr Term kStage12[] = {
    {0, 2.27331014751653820792359768449},    {3, -1.05344954667372501984066689879e+1},
    {4, -2.00087205822486249909675718444},   {5, -1.79589318631187989172765950534e+1},
    {6, 2.79488845294199600508499808837e+1}, {7, -2.85899827713502369474065508674},
    {8, -8.87285693353062954433549289258},   {9, 1.23605671757943030647266201528e+1},
    {10, 6.43392746015763530355970484046e-1}};
inline constexpr Term kStage14[] = {
    {0, 5.61675022830479523392909219681e-2},  {6, 2.53500210216624811088794765333e-1},
    {7, -2.46239037470802489917441475441e-1}, {8, -1.24191423263816360469010140626e-1},
    {9, 1.5329179827876569731206322685e-1},   {10, 8.20105229563468988491666602057e-3},
    {11, 7.56789766054569976138603589584e-3}, {12, -8.298e-3}};
inline constexpr Term kStage15[] = {
    {0, 3.18346481635021405060768473261e-2},   {5, 2.83009096723667755288322961402e-2},
    {6, 5.35419883074385676223797384372e-2},   {7, -5.49237485713909884646569340306e-2},
    {10, -1.08347328697249322858509316994e-4}, {11, 3.82571090835658412954920192323e-4},
    {12, -3.40465008687404560802977114492e-4}, {13, 1.41312443674632500278074618366e-1}};
inline constexpr Term kStage16[] = {
    {0, -4.28896301583791923408573538692e-1}, {5, -4.69762141536116384314449447206},
    {6, 7.68342119606259904184240953878},     {7, 4.06898981839711007970213554331},
    {8, 3.56727187455281109270669543021e-1},  {12, -1.39902416515901462129418009734e-3},
    {13, 2.9475147891527723389556272149},     {14, -9.15095847217987001081870187138}};
inline constexpr Term kEnd[] = {
    {0, 5.42937341165687622380535766363e-2},  {5, 4.45031289275240888144113950566},
    {6, 1.89151789931450038304281599044},     {7, -5.8012039600105847814672114227},
    {8, 3.1116436695781989440891606237e-1},   {9, -1.52160949662516078556178806805e-1},
    {10, 2.01365400804030348374776537501e-1}, {11, 4.47106157277725905176885569043e-2}};
inline constexpr Term kError5[] = {
    {0, 0.1312004499419488073250102996e-01},  {5, -0.1225156446376204440720569753e+01},
    {6, -0.4957589496572501915214079952},     {7, 0.1664377182454986536961530415e+01},
    {8, -0.3503288487499736816886487290},     {9, 0.3341791187130174790297318841},
    {10, 0.8192320648511571246570742613e-01}, {11, -0.2235530786388629525884427845e-01}};
inline constexpr Term kThird[] = {{0, 0.244094488188976377952755905512},
                                  {8, 0.733846688281611857341361741547},
                                  {11, 0.220588235294117647058823529412e-1}};
inline constexpr Term kDense4[] = {
    {0, -0.84289382761090128651353491142e+01},  {5, 0.56671495351937776962531783590},
    {6, -0.30689499459498916912797304727e+01},  {7, 0.23846676565120698287728149680e+01},
    {8, 0.21170345824450282767155149946e+01},   {9, -0.87139158377797299206789907490},
    {10, 0.22404374302607882758541771650e+01},  {11, 0.63157877876946881815570249290},
    {12, -0.88990336451333310820698117400e-01}, {13, 0.18148505520854727256656404962e+02},
    {14, -0.91946323924783554000451984436e+01}, {15, -0.44360363875948939664310572000e+01}};
inline constexpr Term kDense5[] = {
    {0, 0.10427508642579134603413151009e+02},   {5, 0.24228349177525818288430175319e+03},
    {6, 0.16520045171727028198505394887e+03},   {7, -0.37454675472269020279518312152e+03},
    {8, -0.22113666853125306036270938578e+02},  {9, 0.77334326684722638389603898808e+01},
    {10, -0.30674084731089398182061213626e+02}, {11, -0.93321305264302278729567221706e+01},
    {12, 0.15697238121770843886131091075e+02},  {13, -0.31139403219565177677282850411e+02},
    {14, -0.93529243588444783865713862664e+01}, {15, 0.35816841486394083752465898540e+02}};
inline constexpr Term kDense6[] = {
    {0, 0.19985053242002433820987653617e+02},   {5, -0.38703730874935176555105901742e+03},
    {6, -0.18917813819516756882830838328e+03},  {7, 0.52780815920542364900561016686e+03},
    {8, -0.11573902539959630126141871134e+02},  {9, 0.68812326946963000169666922661e+01},
    {10, -0.10006050966910838403183860980e+01}, {11, 0.77771377980534432092869265740},
    {12, -0.27782057523535084065932004339e+01}, {13, -0.60196695231264120758267380846e+02},
    {14, 0.84320405506677161018159903784e+02},  {15, 0.11992291136182789328035130030e+02}};
inline constexpr Term kDense7[] = {
    {0, -0.25693933462703749003312586129e+02},  {5, -0.15418974869023643374053993627e+03},
    {6, -0.23152937917604549567536039109e+03},  {7, 0.35763911791061412378285349910e+03},
    {8, 0.93405324183624310003907691704e+02},   {9, -0.37458323136451633156875139351e+02},
    {10, 0.10409964950896230045147246184e+03},  {11, 0.29840293426660503123344363579e+02},
    {12, -0.43533456590011143754432175058e+02}, {13, 0.96324553959188282948394950600e+02},
    {14, -0.39177261675615439165231486172e+02}, {15, -0.14972683625798562581422125276e+03}};

constexpr std::span<const Term> kStages[16] = {{},      kStage2,  kStage3,  kStage4,  kStage5,  kStage6,
                                               kStage7, kStage8,  kStage9,  kStage10, kStage11, kStage12,
                                               {},      kStage14, kStage15, kStage16};
constexpr std::span<const Term> kDense[4] = {kDense4, kDense5, kDense6, kDense7};

double weighted(std::span<const Term> terms, const RungeKutta::State* k, std::size_t i) {
  double sum = 0;
  for (const Term& term : terms) sum += term.weight * k[term.stage][i];
  return sum;
}

/// y0 + h times a sum of stages, component by component in the lanes.
void combine(std::span<const Term> terms, const RungeKutta::State* k, const RungeKutta::State& y0, double h,
             RungeKutta::State& out) {
  const std::size_t n = y0.size();
  out.assign(n, 0);
  for (const Term& term : terms) {
    const double* stage = k[term.stage].data();
    for (std::size_t j = 0; j < n; ++j) out[j] += term.weight * stage[j];
  }
  for (std::size_t j = 0; j < n; ++j) out[j] = y0[j] + h * out[j];
}

}  // namespace

bool RungeKutta::stage(int i) {
  combine(kStages[i], k_, y0_, h_, work_);
  return f_(t_ + kNodes[i] * h_, work_, k_[i]);
}

double RungeKutta::attempt(double t, const State& y, const State& dy, double h, double tolerance,
                           double unit) {
  constexpr double kFailed = std::numeric_limits<double>::infinity();
  t_ = t;
  h_ = h;
  dense_ready_ = false;
  y0_ = y;
  k_[0] = dy;
  for (int i = 1; i < 12; ++i) {
    if (!stage(i)) return kFailed;
  }
  combine(kEnd, k_, y0_, h, y1_);
  if (!f_(t + h, y1_, k_[12])) return kFailed;

  // The estimates of order 5 and 3 are combined so that the result falls with the eighth power of h.
  double fifth = 0, third = 0;
  for (int j = 0; j < controlled_; ++j) {
    const double scale = tolerance * std::max({unit, std::abs(y[j]), std::abs(y1_[j])});
    const double e5 = weighted(kError5, k_, j) / scale;
    const double e3 = (weighted(kEnd, k_, j) - weighted(kThird, k_, j)) / scale;
    fifth += e5 * e5;
    third += e3 * e3;
  }
  const double both = fifth + 0.01 * third;
  if (both == 0) return 0;
  const double error = h * fifth / std::sqrt(controlled_ * both);
  return std::isfinite(error) ? error : kFailed;
}

bool RungeKutta::prepare_dense() {
  if (dense_ready_) return true;
  for (int i = 13; i < 16; ++i) {
    if (!stage(i)) return false;
  }
  for (State& row : dense_) row.resize(y0_.size());
  for (std::size_t j = 0; j < y0_.size(); ++j) {
    const double change = y1_[j] - y0_[j];
    dense_[0][j] = change;
    dense_[1][j] = h_ * k_[0][j] - change;
    dense_[2][j] = change - h_ * k_[12][j] - dense_[1][j];
    for (int i = 0; i < 4; ++i) dense_[3 + i][j] = h_ * weighted(kDense[i], k_, j);
  }
  dense_ready_ = true;
  return true;
}

void RungeKutta::at(double theta, State& y) const {
  y.resize(y0_.size());
  at(theta, 0, y.size(), y);
}

void RungeKutta::at(double theta, std::size_t first, std::size_t count, State& y) const {
  const double rest = 1 - theta;
  for (std::size_t j = first; j < first + count; ++j) {
    double sum = 0;
    for (int i = 6; i >= 0; --i) sum = (sum + dense_[i][j]) * (i % 2 == 0 ? theta : rest);
    y[j] = y0_[j] + sum;
  }
}

std::array<double, 8> RungeKutta::coefficients(std::size_t i) const {
  std::array<double, 8> c{y0_[i]};
  for (std::size_t j = 0; j < 7; ++j) c[j + 1] = dense_[j][i];
  return c;
}

double step_factor(double error) {
  // Never more than six times longer nor three times shorter, and a tenth below what the estimate allows.
  if (error == 0) return 6;
  if (!std::isfinite(error)) return 0.1;
  return std::clamp(0.9 / std::sqrt(std::sqrt(std::sqrt(error))), 1.0 / 3, 6.0);
}

}  // namespace skerry
