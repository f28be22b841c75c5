//! The noise analysis of one channel.

use crate::cosine_spectrum::CosineSpectrum;
use crate::curve_findings;
use crate::curve_model::CurveModel;
use crate::deviation::curve_of;
use crate::disturbance_findings::disturbance_findings;
use crate::dynamic::windows_of;
use crate::findings;
use crate::quick_fit::without_forms;
use crate::steps::Steps;
use crate::temperature_effect::Temperature;
use crate::{
    AnalysisOptions, ChannelAnalysis, CoefficientFit, FitRecord, NoiseChannel, NoiseRecord,
    SpectrumPoint, TermUnits, chi_square_interval, consistency, converter, converter_traces,
    disturbances, in_units, joint_influence, kalman_noise, robust_fit, state_space, whittle_record,
};
use proofmass_core::Error;
use proofmass_signal::{Detrend, Trend, Welch};
use proofmass_uncertainty::{Figure, Finding};

/// Cosines in one point of the spectrum, at least.
const TOGETHER: f64 = 3.0;

/// Everything about one channel from its stretches, which begin at known places on the sampling clock.
pub(crate) fn analyse_channel(
    channel: &NoiseChannel<'_>,
    record: &FitRecord<'_>,
    sample_rate: f64,
    options: &AnalysisOptions,
    steps: &Steps<'_>,
) -> Result<ChannelAnalysis, Error> {
    let (stretches, starts, samples) = (record.stretches, record.starts, record.samples());
    let (trend, variance) = straight_line(stretches, starts, sample_rate);
    let mut result = ChannelAnalysis {
        name: channel.name.to_owned(),
        unit: channel.unit.to_owned(),
        samples,
        mean: trend.mean,
        standard_deviation: variance.sqrt(),
        trend,
        curve: None,
        further: Vec::new(),
        compensated: None,
        windows: Vec::new(),
        states: None,
        density: None,
        spectrum: Vec::new(),
        whittle: None,
        robust: None,
        fitted: Vec::new(),
        units: Vec::new(),
        kalman: None,
        consistency: Vec::new(),
        disturbances: Vec::new(),
        joint_influence: None,
        converter: Vec::new(),
        findings: Vec::new(),
    };
    let first = stretches[0][0];
    if stretches.iter().all(|s| s.iter().all(|y| *y == first)) {
        result
            .findings
            .push(proofmass_uncertainty::findings::constant_channel(
                "the channel",
                &format!("all {samples} samples are {first}"),
                ": it has no noise to describe",
            ));
        return Ok(result);
    }
    let mut prepared: Vec<Vec<f64>> = Vec::new();
    if options.detrend != Detrend::None {
        for stretch in stretches {
            let mut one = stretch.to_vec();
            if one.len() > 3 {
                options.detrend.remove(&mut one, sample_rate)?;
            }
            prepared.push(one);
        }
    }
    let prepared: Vec<&[f64]> = if prepared.is_empty() {
        stretches.to_vec()
    } else {
        prepared.iter().map(Vec::as_slice).collect()
    };

    let mut fit_options = options.fit.clone();
    channel.unit.clone_into(&mut fit_options.unit);
    // A straight line is part of the likelihood: taking it off before would hide it from the walk too.
    let seen = if options.detrend == Detrend::Quadratic {
        &prepared
    } else {
        stretches
    };
    let seen = FitRecord {
        stretches: seen,
        ..*record
    };
    result.whittle = outcome(
        whittle_record(&seen, sample_rate, &fit_options),
        &mut result.findings,
    );
    if let Some(fit) = result.whittle.as_ref().filter(|_| options.robust) {
        match robust_fit(&seen, fit, sample_rate, &fit_options) {
            Ok(robust) => result.robust = Some(robust),
            Err(error) => result.findings.push(no_robust_fit(&error)),
        }
    }
    steps.one()?;
    let freed = without_courses(&seen, &prepared, sample_rate, result.whittle.as_ref());
    let freed: Option<Vec<&[f64]>> = freed
        .as_ref()
        .map(|f| f.iter().map(Vec::as_slice).collect());
    curves(
        &prepared,
        freed.as_deref(),
        sample_rate,
        options,
        &mut result,
        steps,
    )?;
    // What follows the temperature is neither noise nor a disturbance.
    let prepared = freed.unwrap_or(prepared);
    if options.windows > 0 {
        result.windows = windows_of(
            &prepared,
            starts,
            sample_rate,
            options.windows,
            &options.deviation,
            steps,
        )?;
    }
    steps.one()?;
    let (drawn, slope) = if result.compensated.is_some() {
        let (line, _) = straight_line(&prepared, starts, sample_rate);
        (&prepared[..], line.slope)
    } else {
        (stretches, trend.slope)
    };
    let spectrum = CosineSpectrum::new(drawn, sample_rate, &[]);
    result.spectrum = points(
        &spectrum,
        slope,
        options.deviation.probability,
        result.whittle.as_ref(),
    );
    result
        .findings
        .extend(curve_findings::of_the_curve(&result));
    let longest = longest(&prepared);
    densities(prepared[longest], sample_rate, options, &mut result)?;
    steps.one()?;
    seek_disturbances(&prepared, starts, sample_rate, options, &mut result)?;
    steps.one()?;
    result.converter = converter_traces(stretches[longest]);
    result.findings.extend(converter::converter_findings(
        &result.converter,
        channel.unit,
    ));
    if let Some(fit) = &result.whittle {
        result.kalman = Some(kalman_noise(fit, sample_rate)?);
        result.states = Some(state_space(fit, sample_rate, samples as f64 / sample_rate)?);
        if let Some(sensor) = channel.sensor {
            result.units = fit
                .coefficients
                .iter()
                .filter_map(|c| {
                    let value = c.verdict.value()?;
                    Some(TermUnits {
                        term: c.term,
                        units: in_units(c.term, value, sensor, sample_rate),
                    })
                })
                .collect();
        }
    }
    Ok(result)
}

fn longest(stretches: &[&[f64]]) -> usize {
    (0..stretches.len())
        .max_by_key(|i| (stretches[*i].len(), usize::MAX - i))
        .unwrap_or(0)
}

/// Least-squares straight line through all stretches on one clock, and the variance about the mean.
fn straight_line(stretches: &[&[f64]], starts: &[usize], sample_rate: f64) -> (Trend, f64) {
    let reference = stretches[0][0];
    let each = |f: &mut dyn FnMut(f64, f64)| {
        for (stretch, start) in stretches.iter().zip(starts) {
            for (i, y) in stretch.iter().enumerate() {
                f((start + i) as f64 / sample_rate, y - reference);
            }
        }
    };
    let (mut n, mut t_mean, mut y_mean) = (0.0, 0.0, 0.0);
    each(&mut |t, y| {
        n += 1.0;
        t_mean += t;
        y_mean += y;
    });
    t_mean /= n;
    y_mean /= n;
    let (mut tt, mut ty, mut yy) = (0.0, 0.0, 0.0);
    each(&mut |t, y| {
        tt += (t - t_mean).powi(2);
        ty += (t - t_mean) * (y - y_mean);
        yy += (y - y_mean).powi(2);
    });
    let trend = Trend {
        mean: reference + y_mean,
        slope: if tt > 0.0 { ty / tt } else { 0.0 },
        curvature: 0.0,
    };
    (trend, yy / f64::max(n - 1.0, 1.0))
}

/// The samples without what follows the temperature and without courses that were found; `None` where there is neither.
fn without_courses(
    record: &FitRecord<'_>,
    prepared: &[&[f64]],
    sample_rate: f64,
    fit: Option<&CoefficientFit>,
) -> Option<Vec<Vec<f64>>> {
    let fit = fit?;
    let (lengths, starts) = record.lengths_and_starts(sample_rate);
    let mut sizes = Vec::new();
    let mut forms = Vec::new();
    if let Some(known) = &fit.temperature
        && let Some(sensitivity) = known.taken_off()
        && let Some(temperature) = Temperature::of(record, sample_rate)
    {
        for (form, size) in temperature
            .behind(record, sample_rate, known.lag)
            .iter()
            .zip([sensitivity, known.settling])
        {
            forms.push(form.quiet(sample_rate));
            sizes.push(size);
        }
    }
    for course in &fit.courses {
        let parts = course.shape.forms(&lengths, &starts, sample_rate);
        sizes.extend(&course.parts[..parts.len()]);
        forms.extend(parts);
    }
    (!forms.is_empty()).then(|| without_forms(prepared, &forms, &sizes))
}

fn no_robust_fit(error: &Error) -> Finding {
    findings::no_coefficients(
        "the fit without outliers",
        &error.to_string(),
        "more than a tenth of the samples lie far out, so they are no outliers; look at the time plot",
    )
}

/// The curves, with the degrees of freedom of the fitted noise; `freed` of what follows the temperature.
fn curves(
    stretches: &[&[f64]],
    freed: Option<&[&[f64]]>,
    sample_rate: f64,
    options: &AnalysisOptions,
    result: &mut ChannelAnalysis,
    steps: &Steps<'_>,
) -> Result<(), Error> {
    fn rates<'a>(stretches: &[&'a [f64]]) -> Vec<NoiseRecord<'a>> {
        stretches.iter().map(|s| NoiseRecord::Rate(s)).collect()
    }
    let records = rates(stretches);
    let freed = freed.map(rates);
    let model = result.whittle.as_ref().and_then(|fit| {
        CurveModel::with(&fit.model, freed.as_ref().unwrap_or(&records), sample_rate)
    });
    let curve = |records: &[NoiseRecord<'_>], statistic| {
        curve_of(
            records,
            sample_rate,
            statistic,
            &options.deviation,
            model.as_ref(),
            steps,
        )
    };
    let main = curve(&records, options.statistic)?;
    if let Some(freed) = &freed {
        result.compensated = Some(curve(freed, options.statistic)?);
    }
    let modelled = result.compensated.as_ref().unwrap_or(&main);
    result.further = options
        .further
        .iter()
        .map(|&s| curve(&records, s))
        .collect::<Result<_, Error>>()?;
    if let Some(fit) = &result.whittle {
        result.fitted = crate::consistency::fitted(&fit.model, &fit.band, modelled);
    }
    result.curve = Some(main);
    Ok(())
}

/// The spectrum as points of a plot, freed from the straight line.
fn points(
    spectrum: &CosineSpectrum,
    slope: f64,
    probability: f64,
    fit: Option<&CoefficientFit>,
) -> Vec<SpectrumPoint> {
    let mut bins: Vec<_> = spectrum.bins.iter().collect();
    bins.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let mut points = Vec::new();
    let (mut count, mut density, mut frequency) = (0.0, 0.0, 0.0);
    for bin in bins {
        let seen = bin.freed_of_ramp(slope);
        count += bin.count;
        density += bin.count * seen;
        frequency += bin.count * bin.frequency.ln();
        let wide = count >= TOGETHER && count >= 0.1 * (frequency / count).exp() * spectrum.longest;
        if wide || bin.count > 100.0 {
            let mean = density / count;
            let centre = (frequency / count).exp();
            points.push(SpectrumPoint {
                frequency: centre,
                model: fit
                    .map(|f| f.density(centre, spectrum.sample_rate))
                    .filter(|s| *s > 0.0),
                density: mean,
                // The interval of a deviation, squared, is that of its square.
                interval: chi_square_interval(mean.max(0.0).sqrt(), count, probability)
                    .map(|(low, high)| (low * low, high * high)),
            });
            (count, density, frequency) = (0.0, 0.0, 0.0);
        }
    }
    points
}

/// Disturbances of every stretch, each with its share of the false-alarm rate, and their joint influence.
fn seek_disturbances(
    stretches: &[&[f64]],
    starts: &[usize],
    sample_rate: f64,
    options: &AnalysisOptions,
    result: &mut ChannelAnalysis,
) -> Result<(), Error> {
    let rate = options.disturbance_false_alarm_rate;
    for (stretch, start) in stretches.iter().zip(starts) {
        let share = rate * stretch.len() as f64 / result.samples as f64;
        let mut found = match disturbances(stretch, sample_rate, share) {
            Ok(found) => found,
            // Too short, or constant for a while.
            Err(Error::TooFew { .. } | Error::OutOfRange { .. }) => continue,
            Err(error) => return Err(error),
        };
        let joint = joint_influence(stretch, sample_rate, &found)?;
        if let Some(joint) = joint
            && result
                .joint_influence
                .is_none_or(|j| joint.displacement > j.displacement)
        {
            result.joint_influence = Some(joint);
        }
        for d in &mut found {
            d.samples = (d.samples.0 + start, d.samples.1 + start);
            d.seconds = (
                d.samples.0 as f64 / sample_rate,
                d.samples.1 as f64 / sample_rate,
            );
        }
        result.disturbances.append(&mut found);
    }
    let findings = disturbance_findings(&result.disturbances, result.joint_influence, options);
    result.findings.extend(findings);
    Ok(())
}

/// A fit, or a finding that says why there is none.
fn outcome(
    fit: Result<CoefficientFit, Error>,
    findings: &mut Vec<Finding>,
) -> Option<CoefficientFit> {
    match fit {
        Ok(fit) => {
            findings.extend(fit.findings.iter().cloned());
            Some(fit)
        }
        Err(error) => {
            findings.push(findings::no_coefficients(
                "the fit of the coefficients",
                &error.to_string(),
                match error {
                    Error::TooFew {
                        name: "cosines below the highest frequency",
                        ..
                    } => "set a higher highest frequency, or record longer",
                    _ => "record longer",
                },
            ));
            None
        }
    }
}

/// Welch density for the result, a finer one for the comparison with the Allan curve.
fn densities(
    rate: &[f64],
    sample_rate: f64,
    options: &AnalysisOptions,
    result: &mut ChannelAnalysis,
) -> Result<(), Error> {
    let longest = (rate.len() / 8).max(4);
    let power_of_two = |n: usize| 1_usize << n.max(1).ilog2();
    let segment = options
        .segment
        .unwrap_or_else(|| power_of_two(longest.min(4096)));
    result.density = Some(Welch::new(segment).density(rate, sample_rate)?);
    let fine = power_of_two(longest.min(65_536));
    if let Some(curve) = result.compensated.as_ref().or(result.curve.as_ref())
        && fine >= 64
    {
        // Straight lines are removed piecewise: a walk leaks less.
        let welch = Welch {
            detrend: Detrend::Linear,
            ..Welch::new(fine)
        };
        result.consistency = consistency(&welch.density(rate, sample_rate)?, curve);
        // The curve has the straight line that was taken off, and all stretches of which the density has the longest.
        let part = rate.len() as f64 / result.samples.max(rate.len()) as f64;
        for p in &mut result.consistency {
            p.from_density += 0.5 * (result.trend.slope * p.tau).powi(2);
            p.relative_uncertainty /= part.sqrt();
        }
        let worst = result
            .consistency
            .iter()
            .filter(|p| p.ratio().is_finite())
            .filter(|p| (p.ratio() - 1.0).abs() > 0.1 + 4.0 * p.relative_uncertainty)
            .max_by(|a, b| (a.ratio() - 1.0).abs().total_cmp(&(b.ratio() - 1.0).abs()));
        if let Some(p) = worst {
            result
                .findings
                .push(findings::density_and_allan_differ(p.ratio(), Figure(p.tau)));
        }
    }
    Ok(())
}
