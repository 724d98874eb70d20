// The functions of the maths that WGSL lacks, or has without a bound on its error.
//
// Twin: core/src/num.rs. The fits are those of its f32 lanes, so that both backends make the same
// of an argument. WGSL promises nothing about infinities and NaN: arguments are bounded before they
// could reach one, and nothing is ever tested for them.

#define_import_path fogbank::num

const PI: f32 = 3.1415927;
const HALF_PI: f32 = 1.5707964;
/// √π / 2.
const HALF_SQRT_PI: f32 = 0.8862269;
/// 2 / √π.
const TWO_BY_SQRT_PI: f32 = 1.1283792;
/// The smallest normal number: what a divisor is kept above.
const LEAST: f32 = 1.1754944e-38;

/// Arguments of erf that are 1 apart from it by less than the last bit.
const ERF_END: f32 = 3.75;
/// Where erfc has long vanished.
const ERFC_END: f32 = 9.5;

/// Abscissae and weights of a rule on [0, 1] that is exact to the fifteenth power.
const GAUSS: array<vec2<f32>, 8> = array<vec2<f32>, 8>(
    vec2<f32>(0.0198550718, 0.0506142681),
    vec2<f32>(0.101666761, 0.111190517),
    vec2<f32>(0.237233795, 0.156853323),
    vec2<f32>(0.408282679, 0.181341892),
    vec2<f32>(0.591717321, 0.181341892),
    vec2<f32>(0.762766205, 0.156853323),
    vec2<f32>(0.898333239, 0.111190517),
    vec2<f32>(0.980144928, 0.0506142681),
);

/// Abscissa and weight of one of its eight places.
fn gauss(which: u32) -> vec2<f32> {
    var rule = GAUSS;
    return rule[which];
}

/// e^x, which stops falling at e⁻⁸⁷ and rising at e⁸⁸.
fn exp_bounded(x: f32) -> f32 {
    return exp(clamp(x, -87.0, 88.0));
}

/// ln x of a number that may be 0.
fn log_bounded(x: f32) -> f32 {
    return log(max(x, LEAST));
}

/// 1 − e^−T, which keeps its digits in thin fog.
fn absorptance(depth: f32) -> f32 {
    let series = depth * (1.0 + depth * (depth / 6.0 - 0.5));
    return select(1.0 - exp_bounded(-depth), series, depth < 0.01);
}

/// sin 2πx of an angle in turns.
fn sin_turns(x: f32) -> f32 {
    let turn = x - floor(x + 0.5);
    let folded = select(select(turn, 0.5 - turn, turn > 0.25), -0.5 - turn, turn < -0.25);
    let t = folded * folded;
    let high = 81.601006 + t * (-76.54978 + t * 39.536705);
    return folded * (6.2831855 + t * (-41.341656 + t * high));
}

/// Numerator and denominator of erf as a fraction x·P(x²)/Q(x²).
fn erf_fraction(value: f32) -> vec2<f32> {
    let x = clamp(value, -ERF_END, ERF_END);
    let t = x * x;
    let high = 0.0005281447 + t * (1.0035092e-5 - t * 2.4890764e-7);
    let p = 1.1283852 + t * (0.14168887 + t * (0.042172465 + t * high));
    let q = 1.0 + t * (0.4589628 + t * (0.09017876 + t * 0.008686423));
    return vec2<f32>(x * p, q);
}

/// Error function; absolute error below 1.5e-6, and smooth.
fn erf(x: f32) -> f32 {
    let fraction = erf_fraction(x);
    return fraction.x / fraction.y;
}

/// erf(y) − erf(x) as two look-ups would give it; one division for both, absolute error below 3e-6.
fn erf_plain_difference(x: f32, y: f32) -> f32 {
    let a = erf_fraction(x);
    let b = erf_fraction(y);
    return (b.x * a.y - a.x * b.y) / (a.y * b.y);
}

/// erf(y) − erf(x) for x ≤ y, with relative accuracy also far out in a tail.
fn erf_difference(x: f32, y: f32) -> f32 {
    let ends = vec2<f32>(erfc_positive(abs(x)), erfc_positive(abs(y)));
    // On either side of 0 what is left of 2, else the difference of two tails.
    return select(abs(ends.y - ends.x), 2.0 - ends.x - ends.y, x < 0.0 && y > 0.0);
}

/// erfc(x) for x ≥ 0 with a relative error below 1e-6: a fit of erfcx(x)/t in t = 1/(1 + x/2),
/// written in z = 2t − 1.
fn erfc_positive(value: f32) -> f32 {
    let x = min(value, ERFC_END);
    let t = 1.0 / (1.0 + 0.5 * x);
    let z = 2.0 * t - 1.0;
    let high = -0.0031942825 + z * (0.0013932276 + z * (0.0003556757 - z * 0.00017130875));
    let middle = 0.13972683 + z * (0.018210603 + z * (-0.010692768 + z * high));
    let fit = 0.51079154 + z * (0.34358087 + z * middle);
    return exp_bounded(-x * x) * t * fit;
}

/// Arc tangent of a number from 0 to 1 (Abramowitz and Stegun 4.4.49), to 2e-7.
fn atan_below_one(x: f32) -> f32 {
    let t = x * x;
    let high = 0.042909614 + t * (-0.016165737 + t * 0.0028662257);
    let middle = -0.142089 + t * (0.10656264 + t * (-0.07528964 + t * high));
    return x * (1.0 + t * (-0.33333145 + t * (0.1999355 + t * middle)));
}

/// The angle from 0 to π whose sine and cosine are as `opposite` ≥ 0 to `adjacent`.
fn angle(opposite: f32, adjacent: f32) -> f32 {
    let side = abs(adjacent);
    let steep = opposite > side;
    let ratio = min(opposite, side) / max(max(opposite, side), LEAST);
    let small = atan_below_one(ratio);
    let acute = select(small, HALF_PI - small, steep);
    return select(acute, PI - acute, adjacent < 0.0);
}

/// Arc tangent.
fn arc_tangent(x: f32) -> f32 {
    let size = angle(abs(x), 1.0);
    return select(size, -size, x < 0.0);
}
