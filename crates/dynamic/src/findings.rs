//! Every finding of this room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What frequency responses, shocks, steps and levels may find.
    pub CATALOGUE;

    /// Calibrations of one device, or laboratories of a comparison, contradict each other.
    calibrations_differ(which: &str, evidence: &str, remedy: &str) =
        "calibrations-differ", [Decision],
        what "the {which} differ by more than their uncertainties allow",
        evidence "{evidence}",
        advice "one of them understates its uncertainty, or the device has changed in between: {remedy}";

    /// Differences of two calibrations are larger than their expanded uncertainty.
    normalised_error_above_one(counted: &str, points: &str) =
        "normalised-error-above-one", [Warning],
        what "single differences exceed their expanded uncertainty",
        evidence "{counted}: {points}, with E_n of modulus and phase",
        advice "each asks for a cause (ISO/IEC 17043); whether the calibrations differ as a whole is told by all of them together";

    /// Errors that two calibrations share were taken out of their differences.
    common_causes_taken_out(causes: &str, shared: usize, points: usize, largest: f64, independent: f64) =
        "common-causes-taken-out", [Note],
        what "what both calibrations share is out of U of their differences: {causes}",
        evidence "at {shared} of {points} points; largest |E_n| {largest:.2}, and {independent:.2} if nothing were shared",
        advice "it holds where both go back to one standard with one calibration; where a point is interpolated nothing goes out, and the points are judged one by one";

    /// A calibration has no covariance between its frequencies.
    correlation_not_stated(calibration: &str, evidence: &str, consequence: &str) =
        "correlation-not-stated", [Note],
        what "{calibration} does not say what its frequencies have in common",
        evidence "{evidence}",
        advice "{consequence}";

    /// The sensitivity is another at high level.
    sensitivity_depends_on_level(change: f64, deviations: f64) =
        "sensitivity-depends-on-level", [Warning],
        what "the sensitivity changes with the level",
        evidence "{change:+.2} % at the highest level, {deviations:.0} standard uncertainties",
        advice "state the level with the sensitivity, or correct by the amplitude coefficient";

    /// Damping ratios from width, phase and fit differ.
    dampings_disagree(least: &str, least_value: f64, most: &str, most_value: f64, u: f64) =
        "dampings-disagree", [Note],
        what "the methods for the damping ratio disagree",
        evidence "{least} {least_value:.5}, {most} {most_value:.5}, standard uncertainty of the difference {u:.5}",
        advice "width, peak and phase assume one oscillator that is flat below its resonance, and nothing else; a delay, a second mode, a force as the input or lines too far apart move them: prefer the fit";

    /// The model leaves residuals beyond the uncertainty of the data. A warning for a step, whose intervals have them.
    model_does_not_describe(response: &str, evidence: &str, consequence: &str) =
        "model-does-not-describe", [Decision, Warning],
        what "the model does not describe {response}",
        evidence "{evidence}",
        advice "{consequence}";

    /// A fitted resonance is above all points, or the inverse of a model reaches beyond them.
    model_extrapolated(extrapolated: &str, value: f64, highest: f64, remedy: &str) =
        "model-extrapolated", [Note, Warning],
        what "{extrapolated} lies beyond the frequencies that the model was fitted to",
        evidence "{value:.4} Hz, points up to {highest:.4} Hz",
        advice "{remedy}";

    /// A parameter has a relative uncertainty beyond 20 %.
    parameter_ill_determined(name: &str, relative: f64) =
        "parameter-ill-determined", [Warning],
        what "{name} is hardly determined",
        evidence "relative standard uncertainty {relative:.0} %",
        advice "leave the element out, or measure where it acts";

    /// Steps of a stepped sine are too short.
    steps_too_short(steps: &str, periods: usize) =
        "steps-too-short", [Warning],
        what "some steps are too short and were left out",
        evidence "{steps}; {periods} periods must remain after settling",
        advice "stay longer at each frequency: twelve periods at least, and until the device has settled";

    /// The response changes within steps of a stepped sine.
    step_not_settled(steps: &str) =
        "step-not-settled", [Warning],
        what "the response still changes within some steps",
        evidence "between the two halves: {steps}",
        advice "stay longer at these frequencies, or look whether the level changes within them";

    /// The record ends before what is measured in it. A warning where results are extrapolated, a note where they are those of the
    /// record alone.
    record_ends_early(event: &str, evidence: &str, consequence: &str) =
        "record-ends-early", [Decision, Warning, Note],
        what "the record ends before {event}",
        evidence "{evidence}",
        advice "record longer: {consequence}";

    /// The record begins within what is measured, or too shortly before it to know the noise.
    record_starts_late(event: &str, evidence: &str) =
        "record-starts-late", [Decision, Note],
        what "the record starts too late: {event}",
        evidence "{evidence}",
        advice "use a trigger with an interval before it of several pulse durations or periods";

    /// A record has several pulses.
    more_than_one_pulse(role: &str, time: f64, others: &str) =
        "more-than-one-pulse", [Decision],
        what "the {role} holds more than one pulse; the greatest is evaluated",
        evidence "the greatest at {time:.4} s, others at {others}",
        advice "a rebound is caught by a brake; cut the record to the pulse that is meant";

    /// The level after the pulse is not that before it.
    zero_shift(role: &str, shift: f64, deviations: f64) =
        "zero-shift", [Warning],
        what "the {role} does not return to its level",
        evidence "{shift:.1} % of the peak, {deviations:.0} standard uncertainties",
        advice "a piezoelectric element or its amplifier was overloaded, or the mounting moved; do not use the integral";

    /// The channel oscillates after the pulse.
    ringing(role: &str, amplitude: f64, frequency: f64) =
        "ringing", [Warning],
        what "the {role} rings after the pulse",
        evidence "{amplitude:.0} % of the peak at {frequency:.0} Hz",
        advice "the peak may be that of the ringing: compare with the sensitivities by integral and by spectrum, damp the fixture, or filter both channels alike";

    /// The pulse has fewer than ten samples.
    few_samples(role: &str, samples: usize) =
        "few-samples", [Warning],
        what "the pulse of the {role} has few samples",
        evidence "{samples} within it",
        advice "sample at least ten times within the pulse, better fifty";

    /// Reference and output have their pulses at different times.
    pulses_apart(reference: f64, output: f64, durations: f64) =
        "pulses-apart", [Decision],
        what "reference and output show their pulses at different times",
        evidence "{reference:.4} s and {output:.4} s, {durations:.1} durations apart",
        advice "check that both columns are of one shock and one clock";

    /// The output comes before its cause.
    output_leads(cause: &str, evidence: &str) =
        "output-leads", [Decision, Warning],
        what "the output comes before the {cause}, which no device can",
        evidence "{evidence}",
        advice "the channels may be swapped, or their converters do not sample together";

    /// The sensitivity is negative.
    opposite_sign() =
        "opposite-sign", [Note],
        what "output and reference go to opposite sides",
        advice "the sensitivity is given with its sign; check the mounting";

    /// Two sensitivities of one shock differ.
    peak_and_integral_differ(difference: f64, u: f64) =
        "peak-and-integral-differ", [Warning],
        what "the sensitivities by peak and by integral differ by more than the noise",
        evidence "{difference:+.2} %, standard uncertainty {u:.2} %",
        advice "the device does not follow the pulse: its resonance raises the peak, a high-pass lowers the integral; see the spectrum";
}
