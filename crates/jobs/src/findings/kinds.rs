//! Every finding of the jobs themselves, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What a job may find beside the mathematics it calls.
    pub CATALOGUE;

    /// Recordings that pass for repeats are copies of each other.
    same_recording_twice(first: &str, copies: &str) =
        "same-recording-twice", [Decision],
        what "{first} was given more than once",
        evidence "{copies}: the same to the last byte",
        advice "give every recording once: a copy is no repeat, and what varies from one recording to the next looks smaller than it is",
        false_alarms "none: a file has one digest";

    /// Limits of a data sheet of which no result says anything.
    limit_not_shown(count: usize, limits: &str) =
        "limit-not-shown", [Warning],
        what "limits of the data sheet that no result shows: {count}; they are neither met nor exceeded",
        evidence "{limits}",
        advice "measure what is missing, and give the folder of that result too; `proofmass device plan` names the test that shows each limit",
        false_alarms "none: the quantities of the results are compared by name";

    /// Limits that no measurement of a plan decides.
    plan_out_of_reach(count: usize, limits: &str, why: &str) =
        "plan-out-of-reach", [Warning],
        what "limits of the data sheet that no measurement here will decide: {count} ({limits})",
        evidence "{why}",
        advice "reduce the largest remaining contributions, or expect these limits to stay undecided; a device further from its limit needs less",
        false_alarms "none: the prediction is compared with the margin";

    /// Limits whose typical value nobody stated.
    typical_not_stated(count: usize, ratio: f64, limits: &str) =
        "typical-not-stated", [Note],
        what "no typical value is stated for {count} of the limits",
        evidence "planned for U = tolerance/{ratio}: {limits}",
        advice "write typical = … into the limit: a device nearer to it than to the middle needs a smaller U, one in the middle a larger",
        false_alarms "none: the sheet states a typical value or it does not";

    /// A plan that knows white noise alone.
    slow_noise_not_stated() =
        "slow-noise-not-stated", [Note],
        what "nothing is known of noise slower than white; the plan assumes none",
        evidence "neither B nor K is stated",
        advice "give --noise-result, or a typical value of B or K in the sheet",
        false_alarms "none: they are stated or not";

    /// A limit in a unit that the quantity cannot be converted to.
    limit_not_convertible(device: &str, characteristic: &str, unit: &str, stated: &str) =
        "limit-not-convertible", [Warning],
        what "device {device}: the limit of {characteristic} is in {unit}, and what the results state cannot be converted to it",
        evidence "{stated}",
        advice "write the limit in a unit of the same kind, or measure outputs in the unit of the data sheet",
        false_alarms "none: the dimensions of the units are compared";

    /// A limit holds in a band of which the results show a part.
    limit_band_not_covered(device: &str, characteristic: &str, low: f64, high: f64, first: f64, last: f64) =
        "limit-band-not-covered", [Warning],
        what "device {device}: the limit of {characteristic} holds from {low} to {high} Hz, and was not measured in the whole band",
        evidence "measured from {first} to {last} Hz",
        advice "measure at the ends of the band as well; what lies between two frequencies is not looked at",
        false_alarms "none: the frequencies are compared";

    /// Two results of one quantity of one device differ by more than their uncertainties explain.
    results_contradict(device: &str, quantity: &str, evidence: &str) =
        "results-contradict", [Decision],
        what "device {device}: two results state {quantity} differently, and their uncertainties do not explain it",
        evidence "{evidence}",
        advice "find out which one holds (another temperature, another mounting, a changed device), and leave the other one out; until then the limit is undecided",
        false_alarms "1 % of pairs that agree, or as the request says, where the two share no cause";

    /// The guard bands leave no value that could pass.
    guard_band_too_wide(device: &str, characteristic: &str, expanded: f64, limits: &str) =
        "guard-band-too-wide", [Warning],
        what "device {device}: {characteristic} is not known well enough to pass, whatever its value is",
        evidence "a guard band of {expanded:.3e} on either side of {limits}",
        advice "measure with a smaller U: the two guard bands together are as wide as the limits",
        false_alarms "none: the widths are compared";

    /// Results without a serial number, taken as those of the device beside them.
    device_from_folder(device: &str, count: usize, files: &str) =
        "device-from-folder", [Note],
        what "results that state no serial number, {count} in all, are taken as those of the device {device}, whose results stand beside them",
        evidence "{files}",
        advice "keep the results of a device in a folder of their own",
        false_alarms "none: the folders are compared";

    /// Samples of a recording exceed the accelerations, or the temperatures, of the calibration.
    beyond_calibrated_range(beyond: &str, low: f64, high: f64, unit: &str, treatment: &str, samples: &str) =
        "beyond-calibrated-range", [Note, Warning],
        what "{beyond} beyond {low:.1} … {high:.1} {unit}, where the calibration was tested; {treatment}",
        evidence "{samples}",
        advice "calibrate over a larger range, or refuse such samples";

    /// Columns of a recording are those of its calibration, in another order.
    columns_exchanged(given: &str, known: &str) =
        "columns-exchanged", [Decision],
        what "the outputs are read from columns {given}; the calibration was made with {known}",
        evidence "the same columns in another order",
        advice "leave out --columns, since the calibration names its columns; or be sure that the wires were exchanged",
        false_alarms "none: the names are compared";

    /// Results of several devices are taken for those of one: of a history a decision, of a comparison a warning.
    devices_differ(consequence: &str, device: &str, result: &str, other: &str, other_result: &str, count: usize, remedy: &str) =
        "devices-differ", [Decision, Warning],
        what "these are of several devices: {consequence}",
        evidence "{result} is of {device}, {other_result} of {other}; {count} of them are of another device than the first",
        advice "{remedy}",
        false_alarms "none: serial numbers and types are compared";

    /// A look at a file finds columns without a unit, or no clock.
    file_does_not_say(what: &str, likely: &str) =
        "file-does-not-say", [Note],
        what "the file does not say {what}: a command that needs it asks",
        evidence "{likely}",
        advice "write the unit into the heading, as x_m/s2 or x (g), or say --unit, --time or --rate",
        false_alarms "none: headings are read";

    /// A plan asks for more than the shaker can do.
    beyond_the_shaker(count: usize, points: &str) =
        "beyond-the-shaker", [Decision],
        what "the shaker does not reach {count} of the points that are planned",
        evidence "{points}",
        advice "ask for a smaller acceleration there, lay less on the table, or leave the point out",
        false_alarms "none: the limits of the data sheet are compared";

    /// Decimation folds into the band what the low-pass does not keep out.
    alias_not_suppressed(factor: u32, reached: f64, from: f64, corner: f64, asked: f64) =
        "alias-not-suppressed", [Decision],
        what "a decimation by {factor} folds {from:.6} Hz to {corner} Hz, and the low-pass makes that weaker by {reached:.1} dB only",
        evidence "{asked} dB were asked for",
        advice "lower the corner, leave out fewer samples, or take a low-pass of linear phase; where the recording holds nothing up there, ask for less attenuation",
        false_alarms "none: the gain of the low-pass is computed, and the recording is not looked at";

    /// A compensation filter deviates from the inverse of the sensitivity.
    filter_too_short(taps: usize, departure: f64) =
        "filter-too-short", [Warning],
        what "the filter does not follow the inverse of the sensitivity as closely as was asked",
        evidence "{taps} samples, departure {departure:.2} %",
        advice "leave out the lowest frequencies with a band, or allow a longer filter; the stated error holds it";

    /// A calibration has fewer than three frequencies.
    interpolation_unknown() =
        "interpolation-unknown", [Warning],
        what "the calibration has too few frequencies to determine the sensitivity between them",
        evidence "fewer than three",
        advice "calibrate at more frequencies, or use the compensation at the calibrated ones alone";

    /// The random walk of a bias is known by its upper limit.
    walk_is_a_limit(axes: &str) =
        "walk-is-a-limit", [Note],
        what "{axes}: how the bias walks is not identified; the upper limit is taken",
        evidence "the noise result gives no random walk",
        advice "the intervals are wider than they need be: record the noise for longer";

    /// A table of a calibration has no phase. A note for a reference, to which phases are relative.
    phase_not_stated(table: &str, treatment: &str) =
        "phase-not-stated", [Warning, Note],
        what "the table of a calibration states no phase: {treatment}",
        evidence "{table} has no column phase_deg",
        advice "moduli do not need it; add phase_deg and u_phase_deg where phases or delays count";

    /// A frequency of the campaign meets a resonance of the wedge.
    fixture_resonance(inclination: f64, frequency: f64, u: f64, weight: f64, near: &str) =
        "fixture-resonance", [Decision],
        what "a resonance of the wedge of {inclination:.0}° lies among the frequencies",
        evidence "{frequency:.0} Hz with u = {u:.0} Hz, weight {weight:.1} %; near {near}",
        advice "leave these frequencies out on this wedge, or use another one";

    /// Frequencies of the campaign are beyond those to which the wedge moves as one body.
    fixture_beyond_its_range(inclination: f64, usable: f64, motion: f64, above: usize, frequencies: usize, highest: f64) =
        "fixture-beyond-its-range", [Decision],
        what "the wedge of {inclination:.0}° moves across the excitation by more than the limit",
        evidence "by its model above {usable:.0} Hz more than {motion} %; {above} of {frequencies} frequencies lie there, up to {highest} Hz",
        advice "measure the spurious motion there and correct for it, or leave these frequencies out";

    /// The modes that were calculated are not all that matter.
    modes_missing(observation: &str, evidence: &str) =
        "modes-missing", [Decision],
        what "modes are missing: {observation}",
        evidence "{evidence}",
        advice "ask for more modes: those that were found may not be the ones that matter";

    /// The band of a vibration is not within what the record resolves.
    vibration_band_not_resolved(consequence: &str, evidence: &str) =
        "vibration-band-not-resolved", [Note],
        what "the record does not resolve the whole band of the vibration: {consequence}",
        evidence "{evidence}",
        advice "choose --vibration-band within what length and rate of the record resolve, or sample faster";

    /// The velocity at the end is as large as that of the motion.
    velocity_drifts(end: f64, mean: f64) =
        "velocity-drifts", [Warning],
        what "the velocity does not return: an offset was integrated",
        evidence "{end:.4} m/s at the end, mean acceleration {mean:.3e} m/s²",
        advice "state a correction with --baseline: mean, before=SECONDS or velocity=DEGREE";

    /// A recording of a campaign has no full scale.
    clipping_unchecked() =
        "clipping-unchecked", [Note],
        what "the full scale of the recordings is not known, so clipped samples go unnoticed",
        evidence "[recording] has no full_scale_V",
        advice "add full_scale_V = … to [recording]";

    /// Two tones are too near for the length of the record.
    tones_unresolved(run: &str, frequency: f64, other: &str, file: &str) =
        "tones-unresolved", [Decision],
        what "run {run} was left out: the record does not separate its tone from another",
        evidence "{frequency} Hz and {other} Hz in {file}",
        advice "record for longer than two periods of their difference, or drive one of the two at a time";

    /// A tone of the table is not in the recording.
    tone_missing(run: &str, frequency: f64, reason: &str, file: &str) =
        "tone-missing", [Decision],
        what "run {run} was left out: its recording has no {frequency} Hz",
        evidence "{reason}; {file}",
        advice "check the list of frequencies against the generator; measure the run again, or take the frequency out";

    /// A recording is shorter than the others.
    short_recording(run: &str, duration: f64, rate: f64, file: &str, median: f64) =
        "short-recording", [Warning],
        what "the recording of run {run} is shorter than the others",
        evidence "{duration:.4} s at {rate} Hz in {file}, {median:.4} s in the middle of all runs",
        advice "it may have been cut short; its phasors were used with the uncertainty they have";

    /// A plan takes the spurious motion of an earlier campaign.
    spurious_motion_expected(correction: &str, frequency: f64, u: f64, missing: usize) =
        "spurious-motion-expected", [Note],
        what "the uncertainty of the spurious motion is that of the correction \"{correction}\" at {frequency} Hz",
        evidence "u = {u:.1e} of the excitation in each part of a ratio where it is known least; {missing} inclinations are not in the table and were given that",
        advice "more repeats of the measurement of the spurious motion bring the cross terms down";

    /// A plan has no expected sensitivity.
    sensitivity_assumed() =
        "sensitivity-assumed", [Note],
        what "the expected sensitivity is not stated, so 10 mV/(m/s²) was assumed",
        evidence "the campaign has no [datasheet]",
        advice "it matters where additive noise does; add [datasheet] with sensitivity, tolerance and unit";

    /// The budget has an error of a session, and the plan names one session or none.
    plan_of_one_session(input: &str) =
        "plan-of-one-session", [Note],
        what "all configurations are reckoned as of one session",
        evidence "{input} varies with the session: one error for the whole plan, which no run averages",
        advice "add a column `session` to the plan where the configurations are to be measured in several";

    /// The sensor has a clock of its own.
    own_clock(consequence: &str, phases: &str) =
        "own-clock", [Note],
        what "{consequence}",
        evidence "the sensor samples by a clock of its own, which starts with every file",
        advice "{phases}; for phases stamp both files by one clock (clock = \"shared\")";

    /// Two measurements of a spurious motion differ.
    measurements_disagree(first: &str, second: &str, evidence: &str) =
        "measurements-disagree", [Warning],
        what "the measurements {first} and {second} disagree",
        evidence "{evidence}",
        advice "repeats in a row do not see what changes between two set-ups; take their difference into the uncertainty",
        false_alarms "0.5 % of healthy campaigns, by the level of the test";

    /// A calculated spurious motion is not the measured one.
    calculated_motion_disagrees(calculated: &str, measured: &str, evidence: &str) =
        "calculated-motion-disagrees", [Warning],
        what "the calculated motion {calculated} and the measurement {measured} disagree",
        evidence "{evidence}",
        advice "a model of the wedge alone does not include the motion of the table itself, which is nearly the same at all frequencies; a difference that grows with frequency comes from the base or the adhesive",
        false_alarms "0.5 % of healthy campaigns, by the level of the test";

    /// A calibration is validated by the recording it was made of.
    same_recording() =
        "same-recording", [Warning],
        what "the calibration was made from this very recording: agreement proves nothing",
        advice "record new standstills and validate with them";

    /// A calibration with temperature coefficients is validated without them.
    temperature_not_followed(reference: f64) =
        "temperature-not-followed", [Warning],
        what "the calibration is taken at its reference temperature",
        evidence "{reference:.1} °C",
        advice "record at that temperature, or validate the recording after `proofmass apply`";

    /// A calibration that follows the surroundings is used without them.
    environment_not_followed(name: &str, reference: &str) =
        "environment-not-followed", [Warning],
        what "the calibration is used at its reference value of {name}",
        evidence "{reference}",
        advice "record at that value, or use the recording that `proofmass apply --environment` or `--at` writes",
        false_alarms "none: a property of the calibration";

    /// What a test found of an axis does not make a calibration.
    calibration_not_made(reason: &str) =
        "calibration-not-made", [Warning],
        what "the result holds no calibration: what was found cannot be inverted to compensate the output",
        evidence "{reason}",
        advice "check the readings and their unit; where the curvature is only noise, use --order 1",
        false_alarms "none: the sensitivity of a healthy test differs from zero, and its curvature is a small correction";

    /// A calibration has no covariance.
    calibration_without_uncertainty() =
        "calibration-without-uncertainty", [Warning],
        what "the calibration states no uncertainty: the comparison takes its coefficients as exact",
        advice "judge by the errors in mg, not by χ²; or calibrate here";

    /// A table has several rows of one frequency.
    repeats_averaged(table: &str, most: usize, frequencies: usize) =
        "repeats-averaged", [Note],
        what "rows of one frequency were taken as repeats and averaged",
        evidence "{table}: up to {most} rows at each of {frequencies} frequencies",
        advice "the mean has the stated uncertainty of a row, combined with that of the mean from their scatter";

    /// Edges of an encoder were not recorded.
    edges_lost(lost: usize, rows: usize, largest: f64) =
        "edges-lost", [Warning],
        what "rows jump by more than a count: edges between them are missing, and the samples around have a larger uncertainty",
        evidence "{lost} of {rows} rows, the largest by {largest} counts",
        advice "a capture that is too slow, or a counter that rolls over or was reset: --bits states its width";

    /// The carrier of a resolver was demodulated.
    resolver_demodulated(carrier: f64, block: usize, angles: usize) =
        "resolver-demodulated", [Note],
        what "the carrier of the resolver was demodulated",
        evidence "{carrier:.6} Hz, an angle from every {block} samples, {angles} in all";

    /// The reference is sampled more slowly than the sensors.
    slow_reference(rate: f64, sensors: f64) =
        "slow-reference", [Note],
        what "the reference is slower than the sensors: straight lines stand between its samples",
        evidence "{rate:.4} Hz against {sensors:.4} Hz";

    /// The reference covers a part of the recording.
    cut_to_reference(used: usize, samples: usize) =
        "cut-to-reference", [Note],
        what "only the part that the reference covers is compared",
        evidence "{used} of {samples} samples";

    /// An input in volts and an output in m/s² may be exchanged.
    input_in_volts(input: &str, output: &str) =
        "input-in-volts", [Note],
        what "the input is a voltage and the output an acceleration",
        evidence "{input} in V, {output} in m/s²",
        advice "this is normal for an exciter; of a device the two columns may be swapped, or --standard gives the acceleration from the volts";

    /// A response to noise is asked for, and the input is a swept sine.
    input_is_swept(input: &str, from: f64, to: f64) =
        "input-is-swept", [Warning],
        what "the input is a swept sine, not noise",
        evidence "{input}: its frequency goes steadily between {from:.1} Hz and {to:.1} Hz",
        advice "a segment holds a part of the sweep alone, and its window cuts off the response: evaluate it with `proofmass test sweep`",
        false_alarms "none of 400 records of white noise, of narrow-band noise, of one sine and of two";

    /// Input and output are in one unit, and not of one size: of a device beside its reference one unit is wrong.
    gain_not_one(unit: &str, gain: f64) =
        "gain-not-one", [Warning, Note],
        what "output and input are both in {unit}, and differ greatly in size",
        evidence "the output is {gain:.3e} times the input; an accelerometer beside its reference has about one",
        advice "check the units of the two columns (their headings, --output-unit); of two points of a structure it may be so";

    /// The model that was asked for cannot be fitted to the measured response.
    model_not_fitted(why: &str) =
        "model-not-fitted", [Decision],
        what "the model could not be fitted, and the response is stated without it",
        evidence "{why}",
        advice "choose a model with fewer elements (--model), or narrow --band to where the response is known";

    /// Calibrations have frequencies that the others do not have.
    frequencies_not_compared(compared: usize, lost: &str) =
        "frequencies-not-compared", [Warning, Note],
        what "frequencies that not all calibrations reach were left out of the comparison",
        evidence "{compared} frequencies were compared; beyond them {lost}",
        advice "compare over a wider range, or leave out the calibration that has the fewest";

    /// The result is stated for another mounting than that of the runs.
    mounting_corrected(name: &str, low: f64, high: f64, u: f64, file: &str) =
        "mounting-corrected", [Note],
        what "the sensitivities are those of {name}: what was measured is multiplied by {low:.4} to {high:.4}",
        evidence "{file}, u at most {u:.2} %, one error of all axes and frequencies (mounting.correction in the budget)",
        advice "leave [mounting] out for the sensitivities as they were measured; the ratio is taken as that of every axis",
        false_alarms "none: it is stated";

    /// Two calibrations name a reference standard, which may be the same.
    common_cause_possible(keys: &str, largest: f64, shared: f64) =
        "common-cause-possible", [Note],
        what "both calibrations state an uncertainty of a reference standard, and whether it is the same one is not said: it counts twice in U",
        evidence "{keys}; largest |E_n| {largest:.2}, and {shared:.2} if the two share it",
        advice "where both go back to one standard with one calibration, add --common reference",
        false_alarms "none: the entries of the budgets are counted";

    /// Two calibrations were computed from one file.
    files_of_both(files: &str) =
        "files-of-both", [Note],
        what "the calibrations were computed from the same files: {files}",
        evidence "their digests agree",
        advice "a certificate that is in both is one error of both: name its entry of the budget with --common, such as --common reference",
        false_alarms "none: digests are compared";

    /// Input and output are not coherent.
    low_coherence(limit: f64, poor: usize, lines: usize) =
        "low-coherence", [Warning],
        what "input and output are hardly related over much of the band",
        evidence "coherence below {limit} at {poor} of {lines} lines",
        advice "raise the excitation, check the channels, or narrow --band; noise on the input asks for H2 or Hv";

    /// Nobody said where the noise is, and noise on the input may be most of the uncertainty of what is read from many lines.
    input_noise_unsaid(share: f64, frequency: f64) =
        "input-noise-unsaid", [Note],
        what "noise may be on the input, which makes the response by H1 too small; the uncertainty allows for it",
        evidence "the coherence allows {share:.2} % at {frequency:.0} Hz",
        advice "record both channels while nothing moves: state --estimator h1 where the input has no noise to speak of, h2 where the output has none, or hv with the ratio of both";

    /// The lines are too far apart for a resonance.
    leakage(bias: f64, frequency: f64) =
        "leakage", [Warning],
        what "a resonance is narrower than the lines resolve",
        evidence "bias of {bias:.1} % of the modulus at {frequency:.2} Hz",
        advice "give longer segments (--segment)";

    /// Impacts of a hammer are doubled, clipped or cut off.
    blows_left_out(left_out: usize, blows: usize, reasons: &str) =
        "blows-left-out", [Warning],
        what "{left_out} of {blows} impacts are left out",
        evidence "{reasons}",
        advice "strike once, and let the response decay before the next impact";

    /// A pulse or a shock spectrum cannot be held against its tolerance.
    tolerance_not_judged(subject: &str, evidence: &str, remedy: &str) =
        "tolerance-not-judged", [Decision],
        what "the tolerance of the {subject} cannot be judged",
        evidence "{evidence}",
        advice "{remedy}";

    /// A pulse or a shock spectrum lies outside its tolerance.
    tolerance_missed(subject: &str, evidence: &str) =
        "tolerance-missed", [Decision],
        what "the {subject} does not keep its tolerance",
        evidence "{evidence}",
        advice "change level, pulse former or mounting and repeat the shock, or state another tolerance";

    /// A measured density is beyond a required one.
    spectrum_beyond(profile: &str, by: f64, frequency: f64, lines: usize, all: usize) =
        "spectrum-beyond", [Decision],
        what "the spectrum is beyond the limits of {profile}",
        evidence "by {by:.1} dB at {frequency:.1} Hz; {lines} of {all} lines",
        advice "mend control, fixture or mounting and measure again; one narrow line may be hum or a resonance between table and sensor",
        false_alarms "5 % of Gaussian records at the limit itself, by the level of the intervals; none well within it";

    /// A record does not show whether a required density is kept.
    spectrum_not_shown(profile: &str, lines: usize, all: usize, remedy: &str) =
        "spectrum-not-shown", [Warning],
        what "whether the spectrum keeps {profile} is not shown",
        evidence "the intervals of {lines} of {all} lines reach over a limit",
        advice "{remedy}";

    /// A device does not come back to its baseline after a shock.
    not_back_at_baseline(channel: &str, band: f64, unit: &str, looked: f64) =
        "not-back-at-baseline", [Warning],
        what "{channel} is not back at the baseline before the pulse when the record ends",
        evidence "± {band:.3e} {unit}, looked for {looked:.3e} s after the pulse",
        advice "record for longer; a level that stays is a zero shift: test the device again, or state a wider --return-band",
        false_alarms "1 % of records with white noise that are back at once";

    /// Oscillators of a shock spectrum are fast for the sampling rate.
    few_samples_per_oscillation(frequency: f64, rate: f64, low: f64) =
        "few-samples-per-oscillation", [Note],
        what "the highest oscillators are sampled less than ten times a period",
        evidence "{frequency:.0} Hz at {rate:.0} samples/s: peaks low by up to {low:.0} %",
        advice "look for extremes between the samples (--peaks between-samples), or stay below a tenth of the rate";

    /// The low-pass of a deconvolution acts on the peak.
    little_is_left(u: f64, peak: f64) =
        "little-is-left", [Warning],
        what "what the low-pass removes may be a tenth of the peak or more",
        evidence "standard uncertainty {u:.3e} of {peak:.3e}",
        advice "the device does not follow this motion within its noise: the values are a smoothed picture of it";

    /// A draft of a certificate lacks what a certificate must state.
    certificate_incomplete(count: usize, list: &str) =
        "certificate-incomplete", [Decision],
        what "the certificate lacks {count} of what it must state",
        evidence "{list}",
        advice "add them to LAB.toml or to the file of the order; `proofmass certificate check` lists them one by one",
        false_alarms "none: what a certificate must state is there or not";
}
