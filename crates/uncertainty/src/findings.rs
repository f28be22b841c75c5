//! Every finding of this room, declared once. Rooms above use them where they find the same.

crate::findings! {
    /// What the evaluation of uncertainty may find.
    pub CATALOGUE;

    /// The model is not linear within the uncertainty of its inputs: second-order terms, or Monte Carlo, contradict the law of
    /// propagation. A decision is needed where the intervals differ by a fifth of their half-width and more.
    linear_result_not_validated(name: &str, check: &str, evidence: &str) =
        "linear-result-not-validated", [Warning, Decision],
        what "the linear result of {name} differs from {check}",
        evidence "{evidence}",
        advice "report the Monte Carlo interval";

    /// Monte Carlo and the law of propagation differ because inputs have few degrees of freedom: with standard uncertainties taken as
    /// known they agree. The linear result stands.
    few_degrees_of_freedom_differ(name: &str, evidence: &str) =
        "few-degrees-of-freedom-differ", [Note],
        what "the interval of {name} by Monte Carlo differs from y ± U for few degrees of freedom, not for a curved model",
        evidence "{evidence}",
        advice "JCGM 101 draws Student's t for each input, JCGM 100 takes t at ν_eff; --method monte-carlo states the former";

    /// A unit label is not known to the program.
    unknown_unit(labels: &str) =
        "unknown-unit", [Note],
        what "formulas with unknown unit labels are not checked for their units",
        evidence "{labels}",
        advice "write the unit as the SI brochure does, if it is one";

    /// Temperatures in °C and in K stand in one model.
    two_zeros_of_temperature() =
        "two-zeros-of-temperature", [Decision],
        what "quantities in °C are combined with quantities in K: °C was converted as a difference, without 273.15",
        advice "use one scale, or write t + 273.15 where a temperature in °C is meant as a point of the scale";

    /// The units of a formula contradict each other or the unit of the result.
    units_do_not_fit(formula: &str, contradiction: &str, remedy: &str) =
        "units-do-not-fit", [Decision, Warning],
        what "the formula of {formula} {contradiction}",
        advice "{remedy}";

    /// An angle in degrees is the argument of a trigonometric function.
    degrees_in_trigonometry(formula: &str, angles: &str) =
        "degrees-in-trigonometry", [Decision],
        what "the formula of {formula} takes the sine, cosine or tangent of degrees as if they were radians ({angles})",
        advice "write radians(…) about the angle, state it in rad, or let the units be converted: units = \"convert\" at the head of the file";

    /// χ² of a fit exceeds its quantile.
    residuals_exceed_uncertainty(fit: &str, ratio: &str, dof: usize, limit: &str) =
        "residuals-exceed-uncertainty", [Warning],
        what "the residuals of {fit} are larger than the uncertainty of its points",
        evidence "χ²/ν = {ratio} with ν = {dof}; 99.9 % of healthy fits stay below {limit}",
        advice "add the missing cause to the points, or choose another degree; scatter = \"residuals\" with equal weights estimates it from the residuals",
        false_alarms "0.1 % of healthy fits, by the level of the test";

    /// Earlier results name causes alike.
    shared_causes(causes: &str) =
        "shared-causes", [Note],
        what "causes that earlier results name alike, with the same u, were taken as the same: they correlate the results",
        evidence "{causes}",
        advice "list those that are not the same under `independent` of one of the results";

    /// Earlier results name a cause alike, and its u or ν differ by a little: it is two causes here.
    causes_nearly_alike(causes: &str) =
        "causes-nearly-alike", [Note],
        what "causes that earlier results name alike, with almost the same u, were taken as independent",
        evidence "{causes}",
        advice "if they are one cause, state it with the same digits in both models and evaluate them again: it then correlates the results",
        false_alarms "of two standard deviations of ten readings each, 2.3 % of pairs lie within the 1 % that counts as almost";

    /// An earlier result has findings that need a decision, or it or its model was changed since: what is computed from it needs
    /// one as well.
    earlier_result_in_doubt(file: &str, doubts: &str) =
        "earlier-result-in-doubt", [Decision],
        what "the earlier result {file} needs a decision before it is used",
        evidence "{doubts}",
        advice "settle it there and evaluate both again";

    /// What an earlier result warns of is in its numbers, and goes on with them.
    earlier_result_warned(file: &str, warnings: &str) =
        "earlier-result-warned", [Warning],
        what "the earlier result {file} has warnings, which its numbers bring along",
        evidence "{warnings}",
        advice "read them there, and decide whether the quantities may be used";

    /// The folder of an earlier result has no list of its files: an edit of it that contradicts nothing could not be told.
    earlier_result_unlisted(file: &str) =
        "earlier-result-unlisted", [Note],
        what "no manifest.json beside {file} says that it is as it was written",
        advice "keep the folder of a result whole, and sign results that others build on";

    /// Two earlier results share causes and have trials, because curvature moves their ends: one is drawn by its causes instead, which
    /// keeps what they share and loses the curvature.
    earlier_result_linearised(file: &str) =
        "earlier-result-linearised", [Warning],
        what "{file} is taken as the law of propagation states it, for the causes that it shares with another result",
        advice "compute both results in one model where the ends of the interval matter";

    /// Two earlier results that are stated by their trials have a cause in common: rows of two tables cannot be drawn together.
    shared_causes_of_trials(causes: &str) =
        "shared-causes-of-trials", [Decision],
        what "two earlier results that are stated by Monte Carlo share causes, which are drawn independently here",
        evidence "{causes}",
        advice "compute both results in one model; or list the causes under `independent` where they are not the same";

    /// The double-precision numbers about a value lie farther apart than its uncertainty can use.
    finer_than_doubles(quantity: &str, u: &str, value: &str, spacing: &str) =
        "finer-than-doubles", [Decision],
        what "the uncertainty of {quantity} is lost in the rounding of its value",
        evidence "u = {u}; the numbers that a computer has near {value} lie {spacing} apart",
        advice "state the difference from a fixed reference, or another unit with its own zero";

    /// Repeated observations have one value.
    no_scatter(input: &str, observations: usize, value: f64) =
        "no-scatter", [Warning],
        what "the observations of {input} are all the same",
        evidence "{observations} times {value}",
        advice "add an input for the resolution of the instrument: rectangular, one digit wide";

    /// What grouped observations say of their scatter.
    scatter_of_groups(input: &str, groups: usize, within: &str, between: &str, f: f64, between_dof: usize, within_dof: usize, p_value: f64) =
        "scatter-of-groups", [Note],
        what "the uncertainty of {input} is that of the mean of {groups} groups, whatever causes their scatter",
        evidence "standard deviation within groups {within}, between groups {between}; F = {f:.2} with {between_dof} and {within_dof} degrees of freedom, p = {p_value:.3}";

    /// The model has no value or no derivative at the estimates.
    no_linear_result(reason: &str) =
        "no-linear-result", [Warning],
        what "the law of propagation has no result: the model has no value or no derivative at the estimates",
        evidence "{reason}",
        advice "the result is that of Monte Carlo";

    /// Almost every trial failed.
    no_monte_carlo_result(reason: &str) =
        "no-monte-carlo-result", [Decision],
        what "Monte Carlo has no result: almost no trial gave a number",
        evidence "{reason}",
        advice "the linear result is not checked; state distributions that stay within the possible values";

    /// The observations scatter more than their declared noise.
    excess_residuals(place: &str, evidence: &str, remedy: &str) =
        "excess-residuals", [Warning, Note, Decision],
        what "the residuals exceed the noise: something varies {place} that is not in the budget",
        evidence "{evidence}",
        advice "the uncertainties contain it; {remedy}",
        false_alarms "at most 2.5 % of healthy data, by the level of the test";

    /// Samples stand at the end of the range of converter or amplifier. A warning where nobody declared that range, a note where they
    /// are not used.
    clipped(observation: &str, evidence: &str, consequence: &str) =
        "clipped", [Decision, Warning, Note],
        what "{observation}: samples stand at the limit of the range",
        evidence "{evidence}",
        advice "{consequence}; choose a wider range or a lower gain and record again";

    /// Monte Carlo has too few trials for the digits asked for, or to check the linear interval.
    too_few_trials(purpose: &str, evidence: &str) =
        "too-few-trials", [Warning],
        what "the Monte Carlo trials are too few {purpose}",
        evidence "{evidence}",
        advice "allow more trials or ask for fewer digits";

    /// Correlated inputs have distributions other than the normal one.
    normal_copula(inputs: &str) =
        "normal-copula", [Note],
        what "correlated inputs that are not normal were joined by a normal copula",
        evidence "{inputs}",
        advice "they have the coefficient that is stated (product-moment); other joint distributions have it too, and differ in their tails";

    /// An uncertainty rests on few observations, averages or repeats.
    few_degrees_of_freedom(name: &str, dof: f64, remedy: &str) =
        "few-degrees-of-freedom", [Warning, Note],
        what "the uncertainty of {name} is itself poorly known",
        evidence "ν = {dof:.1}",
        advice "{remedy}";

    /// Correlated inputs have finite degrees of freedom.
    separately_estimated(inputs: &str) =
        "separately-estimated", [Note],
        what "correlated inputs with finite degrees of freedom were taken as estimated separately",
        evidence "{inputs}",
        advice "if they were observed together, list them under `together`: their covariance then has one number of degrees of freedom";

    /// One input, neither normal nor Student, has most of the variance.
    dominant_non_normal_input(distribution: &str, name: &str, input: &str, fraction: f64) =
        "dominant-non-normal-input", [Note],
        what "one {distribution} input dominates {name}: the result is not normal",
        evidence "{input} has {fraction:.0} % of the variance",
        advice "a coverage factor from Student's t overstates the interval; use the Monte Carlo interval";

    /// Trials without a finite value were left out. A note where they cannot move the ends of the interval.
    invalid_trials(name: &str, extent: &str, consequence: &str, invalid: usize, trials: usize, percentage: &str) =
        "invalid-trials", [Decision, Note],
        what "{name} is not a finite number in {extent} trials; {consequence}",
        evidence "{invalid} of {trials}, {percentage} %",
        advice "state distributions of the inputs that stay within the possible values: truncated, rectangular, lognormal";

    /// The standard deviation of the trials does not converge.
    no_standard_deviation(name: &str) =
        "no-standard-deviation", [Warning],
        what "the trials of {name} have tails so heavy that their standard deviation does not converge",
        advice "state the Monte Carlo interval with the median; look for a division by something that reaches zero, and for inputs from three observations or fewer";

    /// A channel has one value throughout where it should move.
    constant_channel(channel: &str, evidence: &str, consequence: &str) =
        "constant-channel", [Decision],
        what "{channel} never changes{consequence}",
        evidence "{evidence}",
        advice "check column, cable, supply and range: a working sensor shows at least its noise";

    /// An output holds one value for a while, as no working sensor does.
    frozen(output: &str, evidence: &str, remedy: &str) =
        "frozen", [Decision],
        what "{output} stood still: the sensor, its converter or its reader hung",
        evidence "{evidence}",
        advice "{remedy}";

    /// A slower sensor was recorded at the rate of a faster one; a note where the repetitions were left out.
    repeated_samples(treatment: &str, evidence: &str) =
        "repeated-samples", [Warning, Note],
        what "samples are repeated: the sensor is slower than the recording{treatment}",
        evidence "{evidence}",
        advice "record at the output data rate of the sensor, or use only the first of each: repeated values look like independent ones and make uncertainties too small";

    /// Samples are missing.
    gaps_in_record(treatment: &str, evidence: &str, remedy: &str) =
        "gaps-in-record", [Warning, Note],
        what "samples are missing{treatment}",
        evidence "{evidence}",
        advice "look for lost packets, a logger that pauses, or a clock that leaps; {remedy}";

    /// A long recording is represented by means of successive samples.
    averaged_record(treatment: &str, evidence: &str, remedy: &str) =
        "averaged-record", [Note],
        what "the recording is long: {treatment}",
        evidence "{evidence}",
        advice "{remedy}";

    /// Time stamps scatter about even steps, as those of a computer do. A warning where the samples are known to be even.
    uneven_stamps(treatment: &str, evidence: &str, remedy: &str) =
        "uneven-stamps", [Note, Warning],
        what "the time stamps are uneven: {treatment}",
        evidence "{evidence}",
        advice "{remedy}";

    /// Gravity, a velocity change, or the ratio of two channels says that a unit is wrong.
    unit_suspected(observation: &str, evidence: &str) =
        "unit-suspected", [Decision],
        what "a unit seems wrong: {observation}",
        evidence "{evidence}",
        advice "check the units of the columns, that of time included: every result is wrong until they agree";

    /// Noise of the thermometer flattens a coefficient.
    noisy_thermometer(coefficient: &str, evidence: &str) =
        "noisy-thermometer", [Warning],
        what "the noise of the thermometer makes {coefficient} too small",
        evidence "{evidence}",
        advice "let the temperature change more, record longer, or average the thermometer";

    /// The innovations of a filter are correlated.
    innovations_correlated(model: &str, evidence: &str, remedy: &str) =
        "innovations-correlated", [Warning, Decision, Note],
        what "the innovations are correlated: {model}",
        evidence "{evidence}",
        advice "{remedy}";

    /// A quantity exceeds its limit with its whole interval.
    beyond_limit(subject: &str, evidence: &str, remedy: &str) =
        "beyond-limit", [Decision],
        what "{subject} beyond the limit with the whole interval",
        evidence "{evidence}",
        advice "{remedy}";

    /// A limit lies within the interval of a quantity.
    limit_undecided(subject: &str, evidence: &str, remedy: &str) =
        "limit-undecided", [Warning],
        what "the limit lies within the interval of {subject}: conformity is undecided",
        evidence "{evidence}",
        advice "{remedy}";

    /// No uncertainty was stated of a surface or axis that is levelled. A note for what is predicted before measuring.
    level_taken_as_exact(level: &str, evidence: &str, remedy: &str) =
        "level-taken-as-exact", [Warning, Note],
        what "{level} is taken as exactly level",
        evidence "{evidence}",
        advice "{remedy}";
}
