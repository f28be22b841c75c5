//! Every finding of this room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What a calibration on a shaker may find.
    pub CATALOGUE;

    /// A correction has no entry for some of the runs.
    correction_incomplete(label: &str, missing: usize, first: &str) =
        "correction-incomplete", [Warning],
        what "the correction \"{label}\" does not cover the whole campaign",
        evidence "{missing} inclinations and frequencies have no entry and were not corrected, the first is {first}; the motion there is an unknown",
        advice "measure the spurious motion there too, or check the angles and frequencies of its table";

    /// Nobody measured the motion of the bench beside the excitation, and nobody states how large it may be.
    motion_not_measured(frequencies: usize, sizes: &str) =
        "motion-not-measured", [Warning],
        what "the motion of the bench was not measured. Across the excitation its size is estimated from the runs; along it, the part that all wedges have in common is assumed",
        evidence "at {frequencies} frequencies; standard uncertainty of each part, at most: {sizes}; along it a wedge is taken to bend as one whose first natural frequency is 3.8 kHz",
        advice "measure it (a campaign of kind spurious-motion) and name its table in [[correction]], or state in [unmeasured_motion] how large it may be";

    /// Nobody measured the motion of the bench beside the excitation, and its size is stated.
    motion_declared(frequencies: usize, sizes: &str) =
        "motion-declared", [Note],
        what "the motion of the bench beside the excitation was not measured; its size is that of [unmeasured_motion], or larger where the runs say so",
        evidence "at {frequencies} frequencies; standard uncertainty of each part, at most: {sizes}",
        advice "measure it for a smaller uncertainty";

    /// A table of the motion of the bench states no uncertainty.
    motion_taken_as_exact(label: &str, axes: &str) =
        "motion-taken-as-exact", [Warning],
        what "the correction \"{label}\" states no uncertainty of the motion along {axes}: it is taken as exact",
        advice "add the columns u_x_ratio and u_x_phase (or u_x_real and u_x_imaginary) of each axis: what the vibrometer and its alignment leave open goes into U";

    /// A sensitivity rises with frequency.
    resonance_onset(term: &str, rise: f64, frequency: f64, resonance: f64) =
        "resonance-onset", [Note],
        what "S_{term} rises towards a resonance",
        evidence "{rise:.1} % above its median at {frequency} Hz; an undamped resonance near {resonance:.0} Hz would do that",
        advice "do not use the sensitivity of lower frequencies there";

    /// A sensitivity is not that of the datasheet. A decision where it is off by three times what tolerance and U allow, or by more than
    /// 15 % and one and a half times that, which no device is.
    off_datasheet(observation: &str, allowed: f64, remedy: &str) =
        "off-datasheet", [Decision, Warning],
        what "{observation}",
        evidence "tolerance and U together {allowed:.2} %",
        advice "{remedy}",
        false_alarms "none where the datasheet is right: a device beyond its tolerance is told";

    /// The datasheet promises nothing at some frequencies.
    datasheet_silent(evidence: &str) =
        "datasheet-silent", [Note],
        what "the datasheet promises nothing at some of the frequencies: the sensitivities there are held against no tolerance",
        evidence "{evidence}",
        advice "state the bands as the sheet prints them, in [[datasheet.band]] with frequency_Hz and tolerance_%",
        false_alarms "none: the bands are stated";

    /// No frequency was measured twice.
    repeatability_unseen(frequencies: usize) =
        "repeatability-unseen", [Note],
        what "no run was repeated: how well a run repeats was not seen",
        evidence "one run at each of {frequencies} frequencies; U contains what the budget declares of a reading and what the recordings tell of noise",
        advice "measure at one frequency three times at least, taking the device off in between",
        false_alarms "none: the runs are counted";

    /// A primary calibration states little or nothing of what its samples do not show.
    primary_budget_incomplete(what: &str, missing: &str) =
        "primary-budget-incomplete", [Warning, Note],
        what "{what}",
        evidence "not stated: {missing}",
        advice "state each in [[budget]] with u_relative and u_phase_deg, the laser and the clock in [interferometer], delays in [recording]; zero where it was found to be nothing",
        false_alarms "none: the inputs are counted";

    /// The highest frequency is beyond 1 kHz.
    adhesive_mounting(highest: f64) =
        "adhesive-mounting", [Warning],
        what "above 1 kHz an adhesive mounting changes the sensitivity",
        evidence "highest frequency {highest} Hz; published: −0.9 % at 2 kHz and −1.9 % at 3 kHz against a stud",
        advice "mount by a stud, or state the mounting with the result";

    /// Runs that contradict the others were left out until somebody decides.
    runs_set_aside(runs: &str, names: &str, changes: &str) =
        "runs-set-aside", [Decision],
        what "{runs} not in the result",
        evidence "run {names}: {changes}",
        advice "the intervals there reach the result with them until that is decided: measure these runs again, or leave them out by name";

    /// The published method was asked for.
    published_method() =
        "published-method", [Note],
        what "the published method is shown for comparison; its intervals are too narrow",
        evidence "it loses the signs of cross terms and averages common errors away",
        advice "use the complex or the joint result";

    /// A check standard, or the device along its axis, deviates from its calibration.
    not_as_calibrated(device: &str, consequence: &str, evidence: &str) =
        "not-as-calibrated", [Decision],
        what "{device} is not what it is known to be{consequence}",
        evidence "{evidence}",
        advice "check reference, gains, cables and mounting, and measure again; a device that was dropped affects only itself";

    /// The check standard is not calibrated at every frequency.
    check_standard_partial(frequencies: &str) =
        "check-standard-partial", [Warning],
        what "the check standard is not calibrated at every frequency: the bench is unchecked there",
        evidence "{frequencies}",
        advice "have the check standard calibrated there";

    /// One line of the certificate does not fit the course of the sensitivity over frequency.
    certificate_off(frequency: f64, second: &str, count: usize, deviation: f64, u: f64, gain: f64) =
        "certificate-off", [Decision],
        what "the certificate of the reference does not fit at {frequency} Hz{second}",
        evidence "all main terms together are {deviation:.2} % off what a resonance and a high-pass through the {count} frequencies give, u = {u:.2} %, χ² falls by {gain:.0}",
        advice "compare that line of the certificate with its neighbours and with the last calibration of the reference";

    /// A configuration of the plan has no run.
    missing_configuration(configuration: &str, frequency: f64, runs: usize, planned: usize) =
        "missing-configuration", [Warning],
        what "there is no run at {configuration}, {frequency} Hz",
        evidence "{runs} runs at {frequency} Hz, {planned} in the plan",
        advice "the uncertainty already includes the loss; measure the configuration if possible";

    /// A configuration was measured more than once.
    duplicate_configuration(configuration: &str, frequency: f64, times: usize, runs: &str) =
        "duplicate-configuration", [Warning],
        what "{configuration} at {frequency} Hz was measured {times} times",
        evidence "runs {runs}",
        advice "if it is one run entered twice, take one out; true repeats have the same mounting error";

    /// A run has a configuration that was not planned.
    unplanned_configuration(run: &str, configuration: &str) =
        "unplanned-configuration", [Note],
        what "run {run} is not in the plan",
        evidence "{configuration}",
        advice "it was used";

    /// Two runs have the same phasors.
    copied_run(observation: &str, evidence: &str) =
        "copied-run", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "one of the two was copied; measure it again or leave it out";

    /// Runs fit the others when channels are exchanged.
    swapped_channels(observation: &str, evidence: &str) =
        "swapped-channels", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "check the cables against the axes marked on the device; exchange the channels of these runs in the table or in [recording], measure them again or leave them out; x and y with opposite signs are a rotation template off by 90°";

    /// A channel has the opposite sign, in single runs or, as a warning, in all.
    inverted_channel(observation: &str, evidence: &str) =
        "inverted-channel", [Decision, Warning],
        what "{observation}",
        evidence "{evidence}",
        advice "check the polarity of the channel: in every run it is right for an inverting amplifier; measure a single run again or leave it out";

    /// A run fits the others at another inclination or rotation.
    wrong_configuration(observation: &str, evidence: &str) =
        "wrong-configuration", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "check wedge and rotation in the record of the run; measure it again or leave it out";

    /// A run fits the others with another gain.
    wrong_gain(observation: &str, evidence: &str) =
        "wrong-gain", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "check the gains in the record of the run; measure it again or leave it out";

    /// A run fits those of another frequency.
    wrong_frequency(observation: &str, evidence: &str) =
        "wrong-frequency", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "check the frequency in the record of the run; measure it again or leave it out";

    /// An output of a run has no signal.
    dead_channel(observation: &str, evidence: &str) =
        "dead-channel", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "check cable and amplifier of that output; measure the run again or leave it out";

    /// A run contradicts the others, and no single cause explains it.
    outlier_configuration(observation: &str, evidence: &str) =
        "outlier-configuration", [Decision],
        what "{observation}",
        evidence "{evidence}",
        advice "measure it again or leave it out; the result is without it and its interval reaches the one with it";

    /// Angles in radians were declared as degrees: the phases of a table, or the directions of a turned device.
    radians_as_degrees(angles: &str, evidence: &str, remedy: &str) =
        "radians-as-degrees", [Decision],
        what "the {angles} look like radians that were declared as degrees",
        evidence "{evidence}",
        advice "{remedy}";

    /// The phases of a table are all zero.
    phases_not_measured(runs: usize) =
        "phases-not-measured", [Decision],
        what "the phases of all outputs are 0: they were not measured",
        evidence "in all {runs} runs, also where the excitation is against an axis of the device and the phase is 180°",
        advice "enter the phases as they were read: without them no sign of a sensitivity is known; where the instrument gives no phase, 0° and 180° by the sense of each output are what is needed",
        false_alarms "none: no device has phase 0 in both senses";

    /// The outputs are moduli without phases.
    magnitudes_only(runs: usize) =
        "magnitudes-only", [Warning],
        what "the phases of the outputs were not read: phases and signs of main terms are unknown, and no calibration is written for other commands",
        evidence "{runs} runs of moduli; main terms are taken as positive, cross terms have the sign that the mountings tell, and their part out of phase is zero within its stated uncertainty",
        advice "read the phase of each output against that of the reference: U of the cross terms gets smaller, and an inverted or swapped output shows",
        false_alarms "none: the table has no phases";

    /// The published method alone was asked for.
    published_alone() =
        "published-alone", [Note],
        what "the published method is asked for alone; the result is that of the joint method, and the published one stands beside it",
        evidence "it takes absolute values, treats common errors as independent and divides by cross terms",
        advice "name \"joint\" before it in [method] methods";

    /// One of two tables counts a lag as positive.
    phases_conjugated(evidence: &str) =
        "phases-conjugated", [Decision, Warning],
        what "the phases of the runs and those of the spurious motion run in opposite senses",
        evidence "{evidence}",
        advice "one of the two tables counts a lag as positive; change the sign of its phases";

    /// x and y are inverted together.
    mask_reversed(evidence: &str) =
        "mask-reversed", [Decision, Warning],
        what "x and y are inverted in every run, as if the device were turned by 180° on every wedge",
        evidence "{evidence}",
        advice "check the zero of the rotation template against the marks on the device, then the polarity of both channels";

    /// All outputs are inverted together.
    reference_inverted(evidence: &str) =
        "reference-inverted", [Decision, Warning],
        what "all outputs are inverted against the reference in every run",
        evidence "{evidence}",
        advice "check the polarity of the reference channel";

    /// Rotations or inclinations are counted the other way.
    angle_sense(angles: &str, evidence: &str, definition: &str) =
        "angle-sense", [Decision, Warning],
        what "the {angles} look as if they were counted in the opposite sense",
        evidence "{evidence}",
        advice "{definition}; change the sign in the table of runs";

    /// The spurious motion has the opposite sign.
    spurious_sign(axes: &str, evidence: &str, check: &str) =
        "spurious-sign", [Decision, Warning],
        what "the spurious motion along {axes} has the opposite sign of what the runs say",
        evidence "{evidence}",
        advice "{check} in the table of the spurious motion";

    /// x and y are turned together against the marks.
    mask_offset(angle: f64, frequency: f64, xy: f64, yx: f64, u: f64, askew: f64, limit: f64) =
        "mask-offset", [Warning],
        what "x and y are turned together by {angle:.1}° against the marks of the device",
        evidence "at {frequency} Hz: S_xy/S_yy = {xy:.4}, S_yx/S_xx = {yx:.4}, u = {u:.2}°; {askew:.1} times its other misalignment, limit {limit:.1} (exceeded by 1 % of devices)",
        advice "check the zero of the rotation template: an offset cannot be separated from a rotated sensor; S refers to the marks on the case",
        false_alarms "1 % of healthy devices, by the level of the test";

    /// Mounting angles scatter more than their declared uncertainty.
    angle_prior_too_small(input: &str, ratio: f64, declared: f64, chi_squared: f64, dof: usize) =
        "angle-prior-too-small", [Decision],
        what "the mounting angles of {input} scatter more than declared",
        evidence "the data ask for {ratio:.2} times the declared {declared:.3}°: χ² = {chi_squared:.1} with {dof} degrees of freedom",
        advice "the result is with what the runs support; declare it so, or look for a configuration that was mounted wrongly",
        false_alarms "0.01 % of healthy campaigns, by the level of the test";

    /// Mounting angles scatter less than their declared uncertainty.
    angle_prior_too_large(input: &str, ratio: f64, declared: f64, chi_squared: f64, dof: usize) =
        "angle-prior-too-large", [Note],
        what "the mounting angles of {input} scatter less than declared",
        evidence "the data ask for {ratio:.2} times the declared {declared:.3}°: χ² = {chi_squared:.1} with {dof} degrees of freedom",
        advice "a smaller declared uncertainty would be defensible",
        false_alarms "0.01 % of healthy campaigns, by the level of the test";

    /// A gain changes in the order of the runs.
    gain_drift(outputs: &str, drift: f64, over: &str, expanded: f64) =
        "gain-drift", [Warning],
        what "the gain of {outputs} drifts in the order of the runs",
        evidence "{drift:+.2} % over {over}, U = {expanded:.2} %",
        advice "let conditioner and reference warm up and repeat the first runs at the end; mountings in mixed order tell a drift from the angles; the order is that of the table of runs",
        false_alarms "0.6 % of 1 200 healthy campaigns of 12 and 44 mountings";

    /// The gains of the outputs differ from session to session by more than readings, mountings and declared inputs of a session allow.
    sessions_differ(session: &str, gains: &str, spread: &str, f: f64, nu: f64, left: f64, p: f64) =
        "sessions-differ", [Decision],
        what "the sessions differ by more than their readings and the budget allow; farthest from the mean is session {session}",
        evidence "{gains}; F = {f:.1} with {nu:.0} and {left:.0} degrees of freedom, p = {p:.1e}; from session to session about u = {spread}",
        advice "look at what was set up otherwise (cables, gains, mounting, temperature) and repeat a session, or declare entries of [[budget]] with that u, acts = \"output-modulus\" and \"output-phase\", and varies_with = [\"session\", \"channel\"]; where all outputs differ alike it is the reference (\"reference-modulus\", [\"session\"]). Where nobody declared it, U has it as session.reproducibility, as far as the runs tell",
        false_alarms "0.1 % of 2 000 healthy campaigns of 12 and 44 mountings in 2 to 5 sessions, half of them with a declared change between sessions";

    /// Sessions of which nothing tells whether they reproduce each other. A warning where that is so of all.
    sessions_not_compared(what: &str, evidence: &str) =
        "sessions-not-compared", [Note, Warning],
        what "{what}",
        evidence "{evidence}",
        advice "repeat two runs or more of another session in each session, at the same frequencies; else state how well sessions reproduce each other in [[budget]], with varies_with = [\"session\", \"channel\"]",
        false_alarms "none: the runs are counted";

    /// The phases of the outputs are apart in proportion to frequency, by more than resonances that the moduli allow.
    channel_delays(late: &str, early: &str, delay: f64, expanded: f64, phase: f64, frequency: f64, allowed: f64) =
        "channel-delays", [Warning],
        what "output {late} comes later than output {early}, as if their channels were not sampled together",
        evidence "{delay:.2} µs, U = {expanded:.2} µs: {phase:.2}° at {frequency} Hz; a device whose moduli look like these explains {allowed:.2} µs",
        advice "look up in which order the converter samples and state `delays` in [recording]; where all channels are sampled together the device does it, with more damping than a resonance of Q = 10",
        false_alarms "none of 1 200 healthy campaigns, half of them of strongly damped devices";

    /// The budget has no tilt of the glued device, none that all gluings share, no lean of the wedges, or nothing that the runs on a
    /// wedge share. A decision where the runs show one (p < 10⁻⁴); a warning where they make one likely (p < 0.0025).
    missing_input(input: &str, evidence: &str, declaration: &str) =
        "missing-input", [Note, Warning, Decision],
        what "the budget has no {input}",
        evidence "{evidence}",
        advice "declare {declaration}",
        false_alarms "0.2 % of 2 000 healthy campaigns of 44 mountings";

    /// A drive lies on a harmonic of the mains. A note where the interference could not be measured.
    drive_at_mains(frequencies: &str, mains: &str, evidence: &str) =
        "drive-at-mains", [Warning, Note],
        what "the drive at {frequencies} cannot be separated from a harmonic of the mains at {mains}",
        evidence "{evidence}",
        advice "move the drive by a few resolutions, take a record long enough to separate them, or record once with the drive off";

    /// A run vibrates at another frequency than its table says.
    frequency_mismatch(run: &str, stated: f64, measured: f64) =
        "frequency-mismatch", [Decision],
        what "run {run} does not vibrate at the frequency of the table",
        evidence "{stated} Hz in the table, {measured:.3} Hz in the recording",
        advice "correct the table or leave the run out";

    /// The top of a sine is flat, though the converter is not at its limit.
    flat_topped(channel: &str, run: &str, lost: f64, frequency: f64) =
        "flat-topped", [Decision],
        what "channel {channel} of run {run} has a flat top",
        evidence "third and fifth harmonic are those of a sine that is cut off; {lost:.2} % of the fundamental is lost, at {frequency} Hz",
        advice "an amplifier saturates before the converter does: lower its gain or the drive, and measure it again";

    /// A second tone was fitted.
    tone_beside_drive(run: &str, tone: f64, frequency: f64, amplitude: f64, tones: usize) =
        "tone-beside-drive", [Note],
        what "a tone beside the drive of run {run} was fitted with it",
        evidence "{tone:.3} Hz beside {frequency} Hz, {amplitude:.2e} V at most; {tones} in all",
        advice "near 50 or 60 Hz and their multiples it is mains interference: look for ground loops";

    /// The excitation has harmonics.
    distortion(run: &str, distortion: f64, frequency: f64, admitted: f64) =
        "distortion", [Warning],
        what "the excitation of run {run} is distorted",
        evidence "{distortion:.1} % at {frequency} Hz, {admitted:.0} % admitted",
        advice "lower the amplitude or look for a loose mounting";

    /// The signal of the reference is near its noise.
    low_signal(run: &str, ratio: f64, frequency: f64, wanted: f64) =
        "low-signal", [Warning],
        what "the reference of run {run} is close to its noise",
        evidence "{ratio:.0} dB at {frequency} Hz, {wanted:.0} dB wanted",
        advice "raise the amplitude or the gain, or record for longer";

    /// A run has another amplitude than planned.
    amplitude_off_target(run: &str, amplitude: f64, target: f64, frequency: f64) =
        "amplitude-off-target", [Warning],
        what "run {run} was not driven at its target amplitude",
        evidence "{amplitude:.3} m/s² reached, {target} m/s² wanted at {frequency} Hz",
        advice "check the amplitude control; the sensitivity is not affected, a linearity test is";

    /// The transverse motion of the table is beyond the standard.
    transverse_motion(run: &str, motion: f64, frequency: f64, admitted: f64) =
        "transverse-motion", [Warning],
        what "run {run}: the transverse motion exceeds the limit of ISO 16063-21",
        evidence "{motion:.1} % at {frequency} Hz, {admitted:.0} % admitted",
        advice "correct for the measured spurious motion, balance the load, change the fixture, or leave the frequency out";

    /// The transverse motion of the table is not known.
    transverse_motion_unknown(unknown: usize, runs: usize) =
        "transverse-motion-unknown", [Note],
        what "the transverse motion of the table was not measured",
        evidence "{unknown} of {runs} runs",
        advice "give it as transverse_%; ISO 16063-21 and ISO 16063-31 ask for it";

    /// The clock of the sensor changes from run to run.
    clock_unsteady(scatter: f64, runs: usize, expected: f64, farthest: &str, error: f64) =
        "clock-unsteady", [Warning],
        what "the clock of the sensor varies from run to run by more than the uncertainty of the fitted sines",
        evidence "{scatter:.2} ppm of scatter over {runs} runs, {expected:.2} ppm by the sines; farthest is run {farthest} with {error:+.1} ppm",
        advice "moduli do not depend on it; an oscillator that warms up does this, and so does a run at another frequency than the table says";

    /// Two files were said to share a clock, and do not.
    clocks_differ(error: f64, u: f64) =
        "clocks-differ", [Decision],
        what "the two files are not stamped by one clock",
        evidence "the sine in the file of the sensor is off by {error:+.0} ppm against that in the recording of the bench, u = {u:.1} ppm",
        advice "clock = \"own\" in [output_recording], which gives no phase against the reference; or stamp both files by one clock";

    /// The phases are not proportional to frequency.
    delay_and_more(misfit: f64, dof: usize, delay: f64) =
        "delay-and-more", [Note],
        what "the phases are not those of a delay alone",
        evidence "χ² = {misfit:.1} with {dof} degrees of freedom about a delay of {delay:.6} ms",
        advice "filter and resonance of the sensor turn the phase beyond it; the uncertainty of the delay is enlarged by the misfit";

    /// Several delays give the same phases.
    delay_ambiguous(delay: f64, ambiguity: f64, frequencies: &str) =
        "delay-ambiguous", [Warning],
        what "other delays explain the phases as well",
        evidence "{delay:.4} ms, or another by {ambiguity:.4} ms; {frequencies}",
        advice "phases count modulo a turn: measure at frequencies that lie close together too";

    /// A run was left out by name.
    excluded_run(run: &str, frequency: f64) =
        "excluded-run", [Note],
        what "run {run} was left out as asked",
        evidence "{frequency} Hz";

    /// The certificate does not reach all frequencies.
    reference_out_of_range(frequencies: &str, evidence: &str) =
        "reference-out-of-range", [Decision, Warning, Note],
        what "the certificate of the reference does not reach {frequencies}",
        evidence "{evidence}",
        advice "have the reference calibrated there, or leave these frequencies out";

    /// A frequency lies between two points of the certificate that are far apart.
    reference_gap(low: f64, high: f64, frequencies: &str, ratio: f64, u: f64, others: &str) =
        "reference-gap", [Warning],
        what "the certificate of the reference says nothing between {low} Hz and {high} Hz, where runs lie",
        evidence "{frequencies} Hz; the two points are a factor of {ratio:.1} apart; U contains half the step between their sensitivities, u = {u:.2} %, and no more{others}",
        advice "have the reference calibrated at these frequencies, or by thirds of an octave; a resonance or a high-pass of the reference between the two points is not in U",
        false_alarms "none: it is a property of the table";

    /// The runs of a frequency are too few, or in too few directions.
    frequency_undetermined(frequency: f64, reason: &str, runs: &str) =
        "frequency-undetermined", [Decision],
        what "the runs at {frequency} Hz do not determine the sensitivity and were left out",
        evidence "{reason} at {frequency} Hz: run {runs}",
        advice "check frequency and file of these runs in the table, or measure the missing configurations";

    /// Repeats scatter more than their declared uncertainty.
    scatter_exceeds_reading(frequency: f64, runs: usize, ratio: f64, run: &str, modulus: f64, phase: f64) =
        "scatter-exceeds-reading", [Warning],
        what "the runs at {frequency} Hz scatter more than the declared uncertainty of a reading",
        evidence "{runs} runs, {ratio:.2} times the declared uncertainty; farthest from the mean is run {run} ({modulus:+.3} %, {phase:+.3}°)",
        advice "look at that run, or declare the uncertainty that a reading has",
        false_alarms "0.01 % of healthy frequencies, by the level of the test";

    /// One of the repeats of a frequency is none.
    no_repeat(run: &str, frequency: f64, factor: &str, others: usize, scatter: f64, cause: &str) =
        "no-repeat", [Decision],
        what "run {run} is no repeat of the others at {frequency} Hz: it has {factor} their sensitivity",
        evidence "{others} others, which scatter by {scatter:.3} %",
        advice "{cause}; measure it again, or leave it out by name: exclude in [runs]",
        false_alarms "0.1 % of healthy campaigns where the runs scatter as declared; 0.1 % of frequencies where they scatter more: the levels of its two tests";

    /// The repeats of a frequency differ, and no majority says which is wrong.
    repeats_apart(frequency: f64, runs: &str, ratio: f64, turn: f64) =
        "repeats-apart", [Decision],
        what "the runs at {frequency} Hz are no repeats of each other",
        evidence "runs {runs}: the largest sensitivity is {ratio:.3} times the smallest, their phases differ by up to {turn:.1}°",
        advice "look at gain, range and cable of these runs; measure there three times at least, so that a majority says which is wrong, or leave one out by name: exclude in [runs]",
        false_alarms "0.1 % of healthy campaigns, by the level of the test";

    /// A run across the axis of a transverse test does not follow the others.
    run_off_cosine(run: &str, frequency: f64, departure: f64, scatter: f64, factor: &str) =
        "run-off-cosine", [Decision],
        what "run {run} at {frequency} Hz is off what the other runs across the axis say of its direction",
        evidence "by {departure:.1} % of the sensitivity along the axis; the others scatter by {scatter:.2} %; {factor}",
        advice "look at gain, range, cable and angle of that run; measure it again, or leave it out by name: exclude in [runs]",
        false_alarms "0.01 % of healthy frequencies, by the level of the test";

    /// Repeats have no common phase.
    incoherent_repeats(place: &str, repeats: usize, resultant: f64, deviation: f64, p_value: f64) =
        "incoherent-repeats", [Decision],
        what "the repeats along {place} have no common phase and were not averaged",
        evidence "{repeats} repeats, resultant length {resultant:.2}, circular standard deviation {deviation:.0}°, Rayleigh p = {p_value:.2}",
        advice "record the vibrometer and the reference with one clock; until then this axis has no correction";

    /// Uncertainties from few repeats were pooled.
    spurious_scatter_pooled(label: &str, places: &str) =
        "spurious-scatter-pooled", [Note],
        what "the uncertainties of the spurious motion \"{label}\" were pooled over its wedges and axes",
        evidence "with few repeats the scatter is estimated from all together; at {places}",
        advice "measure ten times, or let `proofmass calibrate` of a spurious-motion campaign write the table";

    /// Ratios of a spurious motion scatter differently.
    spurious_scatter_unequal(label: &str, places: &str) =
        "spurious-scatter-unequal", [Warning],
        what "the ratios of the spurious motion \"{label}\" do not scatter alike",
        evidence "each has the larger one of its own and the pooled uncertainty; at {places}",
        advice "look at the ratio that scatters most; with ten repeats each uncertainty stands for itself";

    /// A table of spurious motion has no degrees of freedom.
    spurious_dof_unsaid(label: &str, frequency: f64, ratio: f64) =
        "spurious-dof-unsaid", [Note],
        what "the number of repeats is not stated for the uncertainties of the spurious motion \"{label}\"",
        evidence "at {frequency} Hz the largest is {ratio:.0} times the smallest, and both are taken as known",
        advice "a column nu with the degrees of freedom (repeats less one) lets them be pooled where they are few";

    /// The output over the direction of a transverse vibration is no cosine.
    not_a_cosine(frequency: f64, second: f64, scatter: f64) =
        "not-a-cosine", [Warning],
        what "the output at {frequency} Hz does not follow the direction as a transverse sensitivity does",
        evidence "twice per turn {second:.2} % of the sensitivity along the axis; the runs scatter by {scatter:.2} %",
        advice "look at cable, mounting and angles; a resonance of the fixture does this too";

    /// Runs along the axis of a transverse test differ.
    axial_runs_disagree(frequency: f64, largest: f64) =
        "axial-runs-disagree", [Decision],
        what "the runs along the axis at {frequency} Hz are no repeats of each other",
        evidence "one is {largest:.0} % from their mean",
        advice "the transverse sensitivity is relative to their mean: measure them again, or leave one out by name";

    /// The samples of a quadrature pair do not cover the turn.
    quadrature_arc(run: &str, arc: f64, u: f64, consequence: &str) =
        "quadrature-arc", [Decision, Warning],
        what "the quadrature signals of run {run} cover less than a full turn{consequence}",
        evidence "{arc:.0}° of the ellipse; the motion is known to {u:.2} % by its correction",
        advice "drive beyond an amplitude of a quarter of the wavelength (158 nm of a helium-neon laser), or let the interferometer drift through fringes while it records";

    /// The light of an interferometer was lost for a while.
    signal_dropout(run: &str, samples: usize, seconds: f64) =
        "signal-dropout", [Decision],
        what "the interferometer lost its signal in run {run}, which was left out",
        evidence "{samples} samples within three tenths of the radius, the first at {seconds:.4} s: the phase is not known across them",
        advice "look at alignment, focus and speckle; measure the run again, or cut the stretch out with between_s";

    /// The phase turns more than half a turn from sample to sample.
    phase_too_fast(run: &str, step: f64, rate: f64, needed: f64) =
        "phase-too-fast", [Decision],
        what "the phase of run {run} turns too fast for the sampling rate, and the run was left out",
        evidence "{step:.2} rad from sample to sample at {rate} Hz, of which 2.83 can be followed",
        advice "sample at {needed:.0} Hz or faster, or drive with less velocity";

    /// A run gives no phase at all.
    interferometer_unusable(run: &str, why: &str) =
        "interferometer-unusable", [Decision],
        what "run {run} gives no motion and was left out",
        evidence "{why}",
        advice "check the channels in [recording]; measure the run again, or leave it out by name";

    /// The samples are far from the corrected circle.
    quadrature_residual(run: &str, residual: f64, remainder: f64) =
        "quadrature-residual", [Warning],
        what "the quadrature signals of run {run} are no ellipse",
        evidence "{residual:.1} % of the radius, root mean square; what the correction leaves makes {remainder:.4} % of the acceleration",
        advice "look at clipping, at stray light and at intensity that changes with the motion";

    /// Two methods of the same samples disagree.
    methods_disagree(method: &str, frequency: f64, departure: f64, e_n: f64) =
        "methods-disagree", [Warning],
        what "{method} disagrees with the sine approximation at {frequency} Hz",
        evidence "{departure:+.3} %, E_n = {e_n:.2} with k = 2",
        advice "distortion, drift within a period and a wrong correction of the quadrature do this; look at the ellipse and the harmonics of the run",
        false_alarms "0.3 % of healthy frequencies: three standard uncertainties";

    /// The device is in antiphase with the motion.
    motion_inverted(frequency: f64, phase: f64) =
        "motion-inverted", [Warning],
        what "the output is in antiphase with the motion by the interferometer",
        evidence "{phase:.1}° at {frequency} Hz",
        advice "exchange cosine and sine in [recording], or write motion = \"against\" into [interferometer] where the phase falls while the surface moves along the axis; keep it where the device inverts";

    /// Nobody said the wavelength.
    wavelength_assumed(nanometres: f64, relative: f64) =
        "wavelength-assumed", [Note],
        what "the wavelength was not stated: it is taken as that of a helium-neon laser",
        evidence "{nanometres} nm with a relative standard uncertainty of {relative:.0e}",
        advice "write wavelength_nm and u_wavelength_relative into [interferometer]";
}
