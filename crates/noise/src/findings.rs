//! Every finding of the noise room, declared once.

use proofmass_uncertainty::{Figure, findings};

findings! {
    /// What the analysis of noise and the comparison of units may find.
    pub CATALOGUE;

    /// The recording is too long to be held in memory, so averages of it are analysed.
    averaged_record(averaged: usize, rate: f64) =
        "averaged-record", [Note],
        what "the spectrum, the coefficients and the disturbances are those of the averaged recording; the Allan curve is that of all samples",
        evidence "averages of {averaged} samples, {rate} Hz",
        advice "the fit allows for the averaging; analyse a shorter part for frequencies above half of this rate";

    /// Rows are missing in the record.
    gaps_in_record(gaps: &str, place: &str, used_rows: usize, rows: usize, treatment: &str) =
        "gaps-in-record", [Note, Warning],
        what "the record has gaps; {treatment}",
        evidence "{gaps}{place}; {used_rows} of {rows} rows used",
        advice "averaging times longer than the stretches between gaps are lost; look for lost packets or a logger that pauses";

    /// The rate of the time stamps is not the stated one.
    uneven_time_stamps(stamp_rate: f64, uncertainty: f64, sample_rate: f64) =
        "uneven-time-stamps", [Warning],
        what "the time stamps do not advance at the stated sampling rate",
        evidence "{stamp_rate:.6}({uncertainty:.0e}) Hz by the stamps, {sample_rate} Hz stated",
        advice "densities are proportional to the rate; leave the rate out to use that of the stamps";

    /// The time stamps scatter, as those of a computer do.
    jittering_time_stamps(jitter: f64, lost: u64) =
        "jittering-time-stamps", [Note],
        what "the time stamps scatter about the line of an even clock; the samples are taken as even",
        evidence "by {jitter:.0} % of the sampling interval; {lost} samples lost by the line",
        advice "this is usual where a computer stamps on arrival; if the sampling itself jitters, frequencies near half the rate are blurred";

    /// Spectrum or Allan curve deviate from the fitted sum of noise terms by more than their scatter. A note where only a part
    /// outside the fitted band deviates.
    noise_model_misfit(statistic: &str, deviation: &str) =
        "noise-model-misfit", [Warning, Note],
        what "the {statistic} deviates from the sum of the noise terms",
        evidence "{deviation}",
        advice "look at the density plot for a bump or a resonance: there the coefficients are biased by up to this deviation; prefer the Allan curve to the coefficients, fit a Gauss–Markov process or sinusoids, or set the highest frequency",
        false_alarms "0.1 % of healthy spectra, by the level of the test";

    /// A filter acts on the noise before it is sampled; the fit uses the band below it, or describes it.
    band_limited(used: Figure, half_rate: Figure, rest: &str) =
        "band-limited", [Note],
        what "the noise is filtered in front of the converter",
        evidence "used 0 to {used} Hz of {half_rate} Hz; {rest}",
        advice "quantisation noise cannot be determined behind a filter; set the highest frequency to choose another band";

    /// The upper part of the spectrum has the form of no noise term.
    resonance_left_out(used: Figure, half_rate: Figure) =
        "resonance-left-out", [Note],
        what "the upper part of the spectrum follows no noise term and was left out",
        evidence "used 0 to {used} Hz of {half_rate} Hz",
        advice "look at the density plot for a resonance or a decimator; set the highest frequency to choose another band";

    /// The distribution of the samples has heavier tails than a Gaussian one.
    heavy_tails(excess_kurtosis: f64, widened: f64) =
        "heavy-tails", [Note],
        what "the samples have heavier tails than Gaussian noise",
        evidence "excess kurtosis {excess_kurtosis:.2}; the interval of N is wider by {widened:.0} % for it",
        advice "look at the time plot for outliers: N includes them; the robust fit leaves them out";

    /// A temperature was recorded that changes no more than its thermometer scatters.
    steady_temperature() =
        "steady-temperature", [Warning],
        what "the temperature does not vary beyond the noise of its thermometer: its coefficient cannot be determined",
        evidence "its slowest changes are no larger than its fastest",
        advice "leave the temperature out, or let it change by several times the noise of the thermometer";

    /// Every sample has the same value.
    constant_channel(samples: usize, value: f64) =
        "constant-channel", [Decision],
        what "the channel does not vary: it has no noise to describe",
        evidence "all {samples} samples are {value}",
        advice "check that the channel is connected and not saturated";

    /// The fit that leaves outliers out has no result.
    no_robust_fit(reason: &str) =
        "no-robust-fit", [Warning],
        what "the fit without outliers has no result",
        evidence "{reason}",
        advice "more than a tenth of the samples lie far out, so they are no outliers; look at the time plot";

    /// The fit to the spectrum has no result.
    no_coefficients(reason: &str, remedy: &str) =
        "no-coefficients", [Warning],
        what "the coefficients cannot be estimated",
        evidence "{reason}",
        advice "{remedy}";

    /// The Allan variance computed from the density is not that of the samples.
    density_and_allan_differ(ratio: f64, tau: Figure) =
        "density-and-allan-differ", [Warning],
        what "the Allan variance does not follow from the density",
        evidence "ratio {ratio:.3} at τ = {tau} s",
        advice "the record is not stationary; look at the time plot for a disturbance";

    /// The recorded temperature is a straight line in time.
    temperature_like_ramp(correlation: f64) =
        "temperature-like-ramp", [Warning],
        what "the temperature changes as a straight line does: a drift with time and one with temperature cannot be separated",
        evidence "their correlation is {correlation:.5}; neither is given",
        advice "leave the ramp out of the terms to ascribe all of the drift to the temperature, or record through a temperature that rises and falls";

    /// The recorded temperature is nearly a straight line in time.
    temperature_near_ramp(correlation: f64) =
        "temperature-near-ramp", [Note],
        what "the temperature changes nearly as a straight line does: its coefficient and the ramp are poorly separated",
        evidence "their correlation is {correlation:.3}; both intervals allow for it",
        advice "record through a temperature that rises and falls";

    /// Noise of the thermometer attenuates the temperature coefficient.
    noisy_thermometer(attenuation: f64, range: Figure) =
        "noisy-thermometer", [Warning],
        what "the noise of the thermometer makes the temperature coefficient too small",
        evidence "by up to {attenuation:.0} %, the fraction of noise in the power of the temperature, over a range of {range} K",
        advice "let the temperature change more, or average the thermometer";

    /// A coefficient is not the same in all units.
    units_differ(coefficients: &str) =
        "units-differ", [Warning],
        what "the units have significantly different coefficients",
        evidence "{coefficients}",
        advice "state the coefficients of each unit; a common value holds for none of them";

    /// A coefficient exceeds its limit with its whole interval.
    beyond_limit(coefficients: &str) =
        "beyond-limit", [Decision],
        what "coefficients exceed their limits with their whole interval",
        evidence "{coefficients}",
        advice "the units do not meet the limits; their measurement uncertainty is allowed for";

    /// A limit lies within the interval of a coefficient.
    limit_undecided(coefficients: &str) =
        "limit-undecided", [Warning],
        what "limits lie within intervals: conformity is undecided",
        evidence "{coefficients}",
        advice "record longer, until the interval lies on one side of the limit";

    /// Units were compared for which no limit is stated.
    no_limit_covers(count: usize, units: usize, names: &str) =
        "no-limit-covers", [Note],
        what "no limit applies to some of the units",
        evidence "{count} of {units}: {names}",
        advice "add limits for their quantities and channels, or compare these units by themselves";

    /// The converter's step hides the noise.
    coarse_resolution(step: Figure, deviation: Figure, unit: &str) =
        "coarse-resolution", [Warning],
        what "the step of the converter is larger than the noise: the coefficients describe the steps",
        evidence "step {step} {unit}, standard deviation of a sample {deviation} {unit}",
        advice "record at a finer range or resolution; white noise below the step cannot be determined";

    /// The recording is faster than the sensor.
    repeated_samples(fraction: f64, rows: f64) =
        "repeated-samples", [Warning],
        what "samples are repeated: the sensor is slower than the recording",
        evidence "{fraction:.0} % of the samples equal the one before: about one new value in {rows:.1} rows",
        advice "record at the output data rate of the sensor; densities below a tenth of its rate are valid";

    /// The output holds one value for a while, then goes on.
    frozen(samples: usize, longest: usize, first: usize) =
        "frozen", [Decision],
        what "the output stood still: the sensor or its reader hung",
        evidence "{samples} samples in runs of equal values, the longest of {longest} from sample {first} of the longest stretch",
        advice "leave these fields empty, so that they count as a gap; with them N is too small, and K may be spurious";

    /// Many small disturbances add up.
    disturbances_together(places: usize, together: &str) =
        "disturbances-together", [Decision],
        what "many small disturbances together change the Allan curve, though none does by itself",
        evidence "{places} places{together}",
        advice "white noise and curve include them: remove the outliers, or state that they belong to the sensor";

    /// Single outliers; a note where there are more than three, which is a property of the sensor.
    isolated_spikes(samples: usize, together: &str) =
        "isolated-spikes", [Warning, Note],
        what "single samples are outliers of Gaussian noise",
        evidence "outliers: {samples}{together}",
        advice "many of them over the whole record mean noise with heavy tails, few of them lost bits";

    /// Something other than noise happened. A decision is needed where it changes the Allan curve.
    disturbance(
        effect: &str, places: usize, kind: &str, from: f64, to: f64, strength: f64, threshold: f64, records: f64,
        influence: f64, displacement: f64,
    ) =
        "disturbance", [Decision, Warning],
        what "the record is disturbed: something other than noise happened, {effect}",
        evidence "places: {places}; the largest is a {kind} from {from:.2} s to {to:.2} s, {strength:.1} robust standard deviations where noise alone reaches {threshold:.1} in one record of {records:.0}; it raises the Allan variance by up to {influence:.1} %, {displacement:.1} times its standard uncertainty",
        advice "cut the record there and analyse the longer part; coefficients of a disturbed record describe the disturbance",
        false_alarms "the stated false-alarm rate of disturbances per record";
}
