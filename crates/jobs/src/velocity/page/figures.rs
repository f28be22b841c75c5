//! Figures that velocity reports share.

use proofmass_core::velocity::IntegratorRule;
use proofmass_motion::{Method, Tuned, channels};
use proofmass_report::{Axis, Series, XyPlot};
use std::f64::consts::{PI, TAU};

/// An ordinate between the extremes of a curve, a quarter of their distance to spare: what runs away beyond it is
/// seen to leave.
pub(super) fn framed(label: &str, unit: &str, curve: &[f64]) -> Axis {
    let low = curve.iter().copied().fold(f64::INFINITY, f64::min);
    let high = curve.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let axis = Axis::linear(label, unit);
    if high > low {
        let pad = 0.25 * (high - low);
        axis.range(low - pad, high + pad)
    } else {
        axis
    }
}

/// An ordinate around zero that shows all but the widest fifth of an interval: a start that is not known leaves the frame.
pub(super) fn framed_interval(label: &str, unit: &str, curve: &[f64], half: &[f64]) -> Axis {
    let mut sizes: Vec<f64> = curve
        .iter()
        .zip(half)
        .map(|(c, h)| c.abs().max(*h))
        .filter(|s| s.is_finite())
        .collect();
    sizes.sort_by(f64::total_cmp);
    let axis = Axis::linear(label, unit);
    match sizes.get(sizes.len() * 4 / 5) {
        Some(&most) if most > 0.0 => axis.range(-1.5 * most, 1.5 * most),
        _ => axis,
    }
}

/// Bode plot of encoder and accelerometer channel of fused filters, over frequency.
pub(super) fn bode(methods: &[(String, Method)], sample_time: f64) -> Option<XyPlot> {
    let methods: Vec<_> = methods
        .iter()
        .filter(|(_, m)| channels(m, sample_time, &[1.0]).is_some())
        .collect();
    if methods.is_empty() {
        return None;
    }
    // From a hundredth of the slowest crossover, or a millionth of the rate, to just below Nyquist.
    let high = 0.49 / sample_time;
    let low = (1e-5 * high).max(1e-3).min(0.1 * high);
    let f: Vec<f64> = (0..=240)
        .map(|i| low * (high / low).powf(f64::from(i) / 240.0))
        .collect();
    let omega: Vec<f64> = f.iter().map(|f| TAU * f).collect();
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::log("modulus", "1").range(1e-3, 4.0),
    );
    let gains: Vec<_> = methods
        .iter()
        .filter_map(|(name, m)| Some((name, channels(m, sample_time, &omega)?)))
        .collect();
    for (i, (name, gains)) in gains.iter().enumerate() {
        let of = |g: fn(&proofmass_motion::ChannelGain) -> f64| -> Vec<f64> {
            gains.iter().map(|c| g(c).max(1e-12)).collect()
        };
        plot = plot
            .series(Series::line(format!("encoder, {name}"), &f, &of(|c| c.encoder)).look(2 * i))
            .series(
                Series::line(
                    format!("accelerometer, {name}"),
                    &f,
                    &of(|c| c.accelerometer),
                )
                .look(2 * i + 1),
            );
    }
    plot = plot.below(Axis::linear("phase", "°").range(-190.0, 190.0));
    for (i, (_, gains)) in gains.iter().enumerate() {
        let degrees = |g: fn(&proofmass_motion::ChannelGain) -> f64| -> Vec<f64> {
            gains.iter().map(|c| g(c).to_degrees()).collect()
        };
        plot = plot
            .series(Series::line("", &f, &degrees(|c| c.encoder_phase)).look(2 * i))
            .series(Series::line("", &f, &degrees(|c| c.accelerometer_phase)).look(2 * i + 1));
    }
    for panel in &mut plot.panels {
        panel.height = 220.0;
    }
    Some(plot)
}

/// The rules that are drawn: of the family of Newton and Cotes the two that everybody knows.
const RULES: [IntegratorRule; 4] = [
    IntegratorRule::Trapezoid,
    IntegratorRule::Simpson,
    IntegratorRule::Tick,
    IntegratorRule::AdamsMoulton3,
];

/// Accuracy functions of the integration rules and of one that was chosen, and what they make of noise against the exact integral.
pub(super) fn integrators(chosen: Option<IntegratorRule>) -> XyPlot {
    let chosen = chosen.filter(|rule| !RULES.contains(rule));
    let rules = || RULES.into_iter().chain(chosen).enumerate();
    let share: Vec<f64> = (1..200).map(|i| f64::from(i) / 200.0).collect();
    let mut plot = XyPlot::new(
        Axis::linear("frequency over Nyquist frequency", "1"),
        Axis::linear("accuracy function |H|·ω", "1").range(0.6, 1.4),
    );
    for (i, rule) in rules() {
        let y: Vec<f64> = share.iter().map(|s| rule.accuracy(PI * s)).collect();
        plot = plot.series(Series::line(rule.label(), &share, &y).look(i));
    }
    plot = plot
        .vertical(0.15, "15 %")
        .below(Axis::log("noise amplification |H|²/T²", "1").range(0.01, 1e3));
    for (i, rule) in rules() {
        let y: Vec<f64> = share
            .iter()
            .map(|s| rule.noise_amplification(PI * s, 1.0))
            .collect();
        plot = plot.series(Series::line("", &share, &y).look(i));
    }
    for panel in &mut plot.panels {
        panel.height = 220.0;
    }
    plot
}

/// Correlation of the innovations with the limits within which 95 % of the values of white ones lie.
pub(super) fn whiteness(tuned: &Tuned) -> XyPlot {
    let lags: Vec<f64> = (1..tuned.autocorrelation.len()).map(|k| k as f64).collect();
    let rho = &tuned.autocorrelation[1..];
    let limit = 1.96 / (tuned.whiteness.samples as f64).sqrt();
    let extreme = rho.iter().fold(1.6 * limit, |m, r| m.max(1.1 * r.abs()));
    XyPlot::new(
        Axis::linear("lag", "samples"),
        Axis::linear("correlation of the innovations", "1").range(-extreme, extreme),
    )
    .series(Series::markers("", &lags, rho).bars(
        &rho.iter().map(|r| r.min(0.0)).collect::<Vec<_>>(),
        &rho.iter().map(|r| r.max(0.0)).collect::<Vec<_>>(),
    ))
    .horizontal(limit, "95 %")
    .horizontal(0.0, "")
    .horizontal(-limit, "")
}

/// Profile of the likelihood over √q, with the line below which q leaves its 95 % interval.
pub(super) fn profile(tuned: &Tuned, angular: bool) -> Option<XyPlot> {
    let points: Vec<(f64, f64)> = tuned
        .profile
        .iter()
        .filter(|(q, value)| *q > 0.0 && *value > -1e3)
        .map(|(q, value)| (q.sqrt(), *value))
        .collect();
    if points.len() < 5 {
        return None;
    }
    let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    let low = y.iter().copied().fold(0.0, f64::min).max(-60.0);
    Some(
        XyPlot::new(
            Axis::log(
                "√q, noise of the acceleration",
                super::unit_of("m/s²", angular),
            ),
            Axis::linear("ln L below its maximum", "1").range(1.1 * low.min(-4.0), 1.0),
        )
        .series(Series::line("", &x, &y).style(proofmass_report::plot::Style::LineAndMarkers))
        .horizontal(-1.92, "95 %"),
    )
}
