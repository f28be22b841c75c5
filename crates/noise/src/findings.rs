//! Every finding of the noise room, declared once.

use proofmass_uncertainty::{Figure, findings};

findings! {
    /// What the analysis of noise and the comparison of units may find.
    pub CATALOGUE;

    /// The rate of the time stamps is not the stated one.
    rate_contradicts_stamps(stamp_rate: f64, uncertainty: f64, sample_rate: f64) =
        "rate-contradicts-stamps", [Warning],
        what "the time stamps do not advance at the stated sampling rate",
        evidence "{stamp_rate:.6}({uncertainty:.0e}) Hz by the stamps, {sample_rate} Hz stated",
        advice "densities are proportional to the rate; leave the rate out to use that of the time stamps";

    /// Spectrum or Allan curve deviate from the fitted sum of noise terms by more than their scatter. A note where only a part
    /// outside the fitted band deviates.
    noise_model_misfit(statistic: &str, deviation: &str) =
        "noise-model-misfit", [Warning, Note],
        what "the {statistic} deviates from the sum of the noise terms",
        evidence "{deviation}",
        advice "look at the density plot for a bump or a resonance: there the coefficients are biased by up to this deviation; prefer the Allan curve to the coefficients, fit a Gauss–Markov process or sinusoids, or set the highest frequency",
        false_alarms "0.1 % of healthy spectra, by the level of the test";

    /// The slowest cycles of a record do not follow the noise that the whole band is fitted with.
    slow_noise_misfit(ratio: f64, chance: f64, whole: Figure, walk: Figure, highest: Figure) =
        "slow-noise-misfit", [Warning],
        what "the slowest cycles do not follow the noise terms of the whole band",
        evidence "the lowest twenty cosines have {ratio:.2} times the power that the fit expects, by chance in {chance:.4} of records; K is {walk} below {highest} Hz, {whole} over the whole band",
        advice "K is that of the lowest frequencies, and its interval holds both: record longer, with the temperature beside (--temperature), before a filter relies on it",
        false_alarms "none of 800 simulated records of noise alone";

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

    /// A fit to the spectrum has no result.
    no_coefficients(fit: &str, reason: &str, remedy: &str) =
        "no-coefficients", [Warning],
        what "{fit} has no result",
        evidence "{reason}",
        advice "{remedy}";

    /// The Allan variance computed from the density is not that of the samples.
    density_and_allan_differ(ratio: f64, tau: Figure) =
        "density-and-allan-differ", [Warning],
        what "the Allan variance does not follow from the density",
        evidence "ratio {ratio:.3} at τ = {tau} s",
        advice "the record is not stationary; look at the time plot for a disturbance";

    /// The recorded temperature is, or nearly is, a straight line in time. A note where both intervals allow for it.
    temperature_like_ramp(separated: &str, correlation: f64, consequence: &str) =
        "temperature-like-ramp", [Warning, Note],
        what "the temperature changes as a straight line does: a drift with time and one with temperature are {separated} separated",
        evidence "their correlation is {correlation:.5}; {consequence}",
        advice "record through a temperature that rises and falls, or leave the ramp out of the terms to ascribe all of the drift to the temperature";

    /// The output follows the recorded temperature with a lag that nobody stated.
    temperature_lag_found(lag: Figure, low: Figure, high: Figure, gain: f64, needed: f64) =
        "temperature-lag-found", [Note],
        what "the output follows the temperature with a lag",
        evidence "a lag of {lag} s ({low} to {high} s) raises twice the log-likelihood by {gain:.1}, and {needed:.1} are needed; all intervals allow for it",
        advice "state the lag where it is known (--temperature-lag), or put the thermometer nearer to the sensor",
        false_alarms "none of 80 simulated records that follow at once";

    /// The lag of the output behind the temperature is too long for the record.
    temperature_lag_open(low: Figure, span: Figure) =
        "temperature-lag-open", [Warning],
        what "the record is too short for the lag of the output behind the temperature: its coefficient cannot be determined",
        evidence "the lag is above {low} s, a fifth of the record of {span} s is the longest that is stated",
        advice "record for five lags at least, put the thermometer nearer to the sensor, or state the lag where it is known (--temperature-lag)";

    /// The output settles after the start of the record.
    output_settles(size: Figure, time: Figure, low: Figure, high: Figure, gain: f64) =
        "output-settles", [Warning],
        what "the output settles after the start of the record: a fitted exponential was subtracted",
        evidence "{size} at the start, time constant {time} s ({low} to {high} s); it raises twice the log-likelihood by {gain:.1}",
        advice "cut the start off (--between FROM TO), or let the sensor warm up before recording; coefficients allow for it, the curve as recorded does not",
        false_alarms "none of 800 simulated records of noise alone";

    /// The level of the output steps; two steps of opposite sign are a change that ends.
    mean_steps(steps: &str) =
        "mean-steps", [Warning],
        what "the level of the output steps: that was taken out of the noise",
        evidence "from the start {steps}",
        advice "look at the time plot for a knock or a change of attitude, and use the part between (--between FROM TO); coefficients allow for it, the curve as recorded does not",
        false_alarms "none of 800 simulated records of noise alone";

    /// The output follows the time of the day.
    day_cycle(size: Figure, gain: f64) =
        "day-cycle", [Warning],
        what "the output has a daily cycle: a fitted cycle was subtracted",
        evidence "amplitude {size}; it raises twice the log-likelihood by {gain:.1}",
        advice "record the temperature too (--temperature): it is the usual cause",
        false_alarms "none of 200 simulated records of noise alone";

    /// A coefficient is not the same in all units.
    units_differ(coefficients: &str) =
        "units-differ", [Warning],
        what "the units have significantly different coefficients",
        evidence "{coefficients}",
        advice "state the coefficients of each unit; a common value holds for none of them";

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
