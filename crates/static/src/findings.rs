//! Every finding of this room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What a static calibration may find.
    pub CATALOGUE;

    /// The centripetal acceleration of a tumble is not small against gravity.
    tumble_fast(turning: f64, pull: f64, lever: f64) =
        "tumble-fast", [Warning],
        what "the sensor was turned fast, and what that adds to gravity is not in the budget",
        evidence "{turning:.2} rad/s in the median: {pull:.2} mg at {lever} m from the axis of turning",
        advice "turn more slowly, about the sensor itself; or lay it down in twelve attitudes";

    /// Accelerations of the hand are not small against gravity.
    tumble_shaken(scatter: f64, lengthened: f64) =
        "tumble-shaken", [Warning],
        what "the sensor was shaken while it was turned",
        evidence "magnitudes scatter by {scatter:.2} m/s² and are {lengthened:.2} mg too long in the mean, which is taken off",
        advice "turn it more smoothly; or lay it down in twelve attitudes";

    /// What is stated as a rest does not read gravity.
    rest_is_not_gravity(read: f64) =
        "rest-is-not-gravity", [Decision],
        what "the sensor does not read gravity where it is stated to be at rest",
        evidence "{read:.4} m/s², 9.81 m/s² were expected",
        advice "check the stretch and the unit, and apply a calibration first";

    /// Parts of a stretch at rest differ.
    rest_moves(angle: f64) =
        "rest-moves", [Warning],
        what "the sensor does not rest where it is stated to: parts of the rest differ",
        evidence "their means by {angle:.2}° of inclination, or by the acceleration that reads alike",
        advice "choose a stretch in which the machine stands still, its engine off and nobody getting in",
        false_alarms "none in 1200 simulated rests; white noise alone does it in one of 10⁶";

    /// The acceleration along the travel has a part along the vertical of the rest.
    travel_leaves_the_level(up: f64, along: f64) =
        "travel-leaves-the-level", [Warning],
        what "the acceleration along the travel does not lie in the level of the rest",
        evidence "{up:.3} m/s² upwards beside {along:.3} m/s² forwards",
        advice "the body squats, the road rises, or the rest was on a slope: roll and pitch may be off by the inclination; rest where the road is that of the travel";

    /// The direction of travel is not well known.
    travel_not_straight(u: f64) =
        "travel-not-straight", [Warning],
        what "the direction of the acceleration changes along the travel",
        evidence "the yaw angle has a standard uncertainty of {u:.2}°",
        advice "choose stretches of stronger acceleration on a straight line, or several of them";

    /// Auto-calibration does not reach the error that its method asks for.
    auto_calibration_failed(before: f64, after: f64, accepted: f64) =
        "auto-calibration-failed", [Decision],
        what "after calibration, |a| of the still windows differs from 1 g by more than the method allows",
        evidence "mean of |‖a‖ − 1| {before:.2} mg before, {after:.2} mg after, {accepted:.0} mg at most",
        advice "keep the calibration of the maker, or calibrate by hand in twelve attitudes";

    /// The iteration was ended by the published rule.
    published_stop(iterations: usize, error: f64) =
        "published-stop", [Warning],
        what "the iteration was stopped by the published criterion, before it converged",
        evidence "{iterations} iterations, {error:.3} mg",
        advice "use it only to compare with programs that stop there";

    /// A rest lies so far from its prediction that it was in another attitude.
    rest_in_another_attitude(axis: &str, rest: usize, time: f64, off: f64, deviations: f64, deviating: usize) =
        "rest-in-another-attitude", [Decision],
        what "{axis}: what a rest reads is not the known acceleration and a bias",
        evidence "rest {rest} at {time:.1} s: {off:.4} m/s² off, {deviations:.1} standard deviations; {deviating} of the rests in all",
        advice "was the sensor turned? state the attitude of every rest in a table of segments";

    /// A rest lies far from its prediction.
    rest_out_of_line(axis: &str, rest: usize, time: f64, off: f64, deviations: f64, deviating: usize) =
        "rest-out-of-line", [Warning],
        what "{axis}: a rest lies further from the prediction than noise and motion of the bias explain",
        evidence "rest {rest} at {time:.1} s: {off:.4} m/s² off, {deviations:.1} standard deviations; {deviating} of the rests in all",
        advice "look for motion during that rest, a step of the bias (shock, temperature, switching), or take a wider initial uncertainty";

    /// Innovations of the bias filter are larger than its noise. A decision beyond a factor of two.
    innovations_too_large(axis: &str, ratio: f64, low: f64, high: f64, means: usize) =
        "innovations-too-large", [Warning, Decision],
        what "{axis}: the innovations are larger than expected from the stated noise",
        evidence "{ratio:.2} times their standard deviation, {low:.2} to {high:.2} by chance over {means} means",
        advice "the intervals are too narrow: take the noise in the state in which this was recorded (mounted, running), or leave out what is no rest";

    /// Innovations of the bias filter are smaller than its noise.
    innovations_too_small(axis: &str, ratio: f64, low: f64, high: f64, means: usize) =
        "innovations-too-small", [Warning],
        what "{axis}: the innovations are smaller than expected from the stated noise",
        evidence "{ratio:.2} times their standard deviation, {low:.2} to {high:.2} by chance over {means} means",
        advice "the intervals are too wide: the noise result is of another sensor, bandwidth or state";

    /// The temperature rose or fell, not both.
    one_direction(low: f64, high: f64) =
        "one-direction", [Note],
        what "in no attitude did the temperature go both ways: hysteresis and lag are in the coefficients and cannot be seen",
        evidence "{low:.1} to {high:.1} °C",
        advice "record the way back as well, at several rates";

    /// The temperature was swept in one attitude only.
    bias_and_scale_together(drift: f64) =
        "bias-and-scale-together", [Note],
        what "in one attitude bias and scale cannot be separated: the coefficients are those of the output there",
        evidence "100 ppm/K of scale would be {drift:.0} µg/K along the specific force",
        advice "sweep the temperature with each axis up and down in turn";

    /// A lag of the thermometer and hysteresis cannot be separated.
    lag_not_determined() =
        "lag-not-determined", [Note],
        what "the temperature ran at one rate: a lag of the thermometer looks as hysteresis does, and is counted there",
        evidence "the rate varies by less than a third within the branches",
        advice "record at several rates, or with plateaus, to separate them";

    /// The output still goes on at the temperatures.
    soak_too_short(rests: usize, minutes: f64, sizes: &str) =
        "soak-too-short", [Warning],
        what "the output still settles while the temperature rests: the sensor is not yet as warm as its thermometer",
        evidence "second half of a rest less the first, in the mean of {rests} rests of some {minutes:.1} min: {sizes}",
        advice "soak for longer before the rest counts, 15 minutes and more, until the output rests too; or sweep slowly, so that the lag is told",
        false_alarms "0.5 % of recordings, by Student's t over the rests";

    /// A quantity of the surroundings hardly differs from the temperature.
    environment_follows(name: &str, own_part: f64) =
        "environment-follows", [Warning],
        what "{name} largely follows the temperature: each coefficient is uncertain, and their sum is known better",
        evidence "{own_part:.1} % of its course is its own",
        advice "change one while the other stays: two sweeps of the temperature at two values of the other quantity",
        false_alarms "none: a property of the recording";

    /// Temperature and self-heating run alike.
    self_heating_not_determined(own_part: f64) =
        "self-heating-not-determined", [Decision],
        what "the temperature ran as self-heating decays: the coefficients and the warming of the sensor cannot be separated",
        evidence "{own_part:.2} % of the decay is not explained by temperature and attitudes",
        advice "hold the temperature after switching on until the output rests, or record the way back too";

    /// The recording was interrupted while the temperature changed. A note where the tilt meanwhile was declared.
    temperature_jump(treatment: &str, jumps: usize, kelvin: f64, change: f64, alternative: &str) =
        "temperature-jump", [Decision, Note],
        what "the temperature jumps: {treatment}",
        evidence "{jumps} of them, the largest by {kelvin:.1} K, where the output changed by {change:.2} mg",
        advice "record while the temperature changes{alternative}";

    /// A step of the output that the temperature does not explain. A decision where it is in the mean slope beyond its interval.
    output_step(treatment: &str, steps: &str) =
        "output-step", [Warning, Decision],
        what "the output steps beside the temperature, as when the sensor is moved: {treatment}",
        evidence "{steps}",
        advice "look at the figure, and record again with the sensor fixed; or leave the samples before or after the step out",
        false_alarms "1 % of healthy recordings, by the level of the test";

    /// Heating and cooling give different outputs.
    hysteresis(axis: &str, difference: f64, expanded: f64, temperature: f64, of_a_reading: f64) =
        "hysteresis", [Warning],
        what "heating and cooling give different outputs on {axis}: no coefficient can correct it, and every reading is uncertain by it",
        evidence "{difference:.2} mg ± {expanded:.2} mg at {temperature:.1} °C",
        advice "count {of_a_reading:.2} mg as standard uncertainty of a compensated reading",
        false_alarms "1 % of healthy recordings, by the level of the test";

    /// The raw difference between heating and cooling is another than the model's.
    branches_beyond_model(axis: &str, raw: f64, model: f64, temperature: f64, of_a_reading: f64) =
        "branches-beyond-model", [Warning],
        what "the difference between heating and cooling on {axis} is not that of the model: the output wanders slowly, or the hysteresis has a form that the model lacks",
        evidence "{raw:.2} mg from the outputs, {model:.2} mg from the model at {temperature:.1} °C",
        advice "count {of_a_reading:.2} mg as standard uncertainty of a compensated reading, and run the cycle twice: wander does not repeat",
        false_alarms "1 % of healthy recordings; 7 % where the output wanders by 1 mg";

    /// There are fewer attitudes than a calibration should have. A decision where nothing checks the fit.
    few_attitudes(consequence: &str, standstills: usize, parameters: usize, remedy: &str) =
        "few-attitudes", [Warning, Decision],
        what "there are few attitudes: {consequence}",
        evidence "{standstills} standstills for {parameters} parameters",
        advice "{remedy}";

    /// A part of the sphere has no attitude. A decision where a reading there has more than 0.1 % of g as U.
    attitudes_badly_spread(coverage: &str, radius: f64, x: f64, y: f64, z: f64, expected: &str) =
        "attitudes-badly-spread", [Decision, Warning],
        what "the attitudes leave a part of the sphere open",
        evidence "{coverage}; no attitude within {radius:.0}° of ({x:+.2}, {y:+.2}, {z:+.2}){expected}",
        advice "record standstills there; until then bias and scale factor of that axis depend on each other, and nothing checks the model there";

    /// The sensor moved during a standstill.
    restless_standstill(standstill: &str, start: usize, end: usize, ratio: f64) =
        "restless-standstill", [Warning],
        what "standstill {standstill} is not still",
        evidence "samples {start} to {end}: {ratio:.1} times the median deviation",
        advice "lay the sensor down instead of holding it, or leave this standstill out (`exclude` in [standstill])";

    /// The residuals follow elements of K that the model does not have.
    model_too_small(model: &str, elements: &str, size: f64, chance: &str, alternative: &str) =
        "model-too-small", [Warning, Decision],
        what "the residuals ask for model {model}",
        evidence "{elements}: up to {size:.2} mg ({chance})",
        advice "fit `model = \"{model}\"`{alternative}";

    /// The bias changes during the recording.
    bias_drift(evidence: &str, remedy: &str) =
        "bias-drift", [Warning, Decision],
        what "the bias drifts during the recording",
        evidence "{evidence}",
        advice "let the sensor settle first; {remedy}";

    /// The biases walk at random during the recording.
    bias_walk(walk: f64, weight: f64) =
        "bias-walk", [Note],
        what "the biases drift at random during the recording: their mean over the standstills is stated",
        evidence "random walk of {walk:.0} µg/√s; of the forms that the scatter may have it gets {weight:.1} % of the weight",
        advice "record in less time, or let the sensor settle first; later the bias differs by more than the stated interval",
        false_alarms "0.02 % of healthy recordings, 0.2 % of the worst kind";

    /// The output settles after switching on. A note where the coefficients are those of the warm sensor.
    warm_up(observation: &str, evidence: &str) =
        "warm-up", [Warning, Decision, Note],
        what "the sensor warmed itself after it was switched on: {observation}",
        evidence "{evidence}",
        advice "switch the sensor on several time constants earlier, or leave out the beginning";

    /// The temperature changed across the standstills, or the residuals follow it, and the model has no term for it. A decision
    /// beyond 10 K.
    temperature_dependence(observation: &str, evidence: &str) =
        "temperature-dependence", [Warning, Decision],
        what "{observation}, and the model has no temperature term",
        evidence "{evidence}",
        advice "fit a temperature term (`[terms]`), or let the sensor settle before recording; the calibration holds for the mean temperature";

    /// The output is no straight line of the acceleration. A note where a linearity test finds more than 0.1 % of full scale.
    nonlinear_output(form: &str, evidence: &str, consequence: &str) =
        "nonlinear-output", [Warning, Decision, Note],
        what "the output is not linear: {form}",
        evidence "{evidence}",
        advice "{consequence}; compensate the curvature, or stay within the range in which a line holds";

    /// The residuals follow the direction from which an attitude was reached.
    last_motion(x: f64, y: f64, z: f64, chance: &str) =
        "last-motion", [Warning, Decision],
        what "the outputs depend on the direction from which an attitude was reached: hysteresis, friction or play",
        evidence "±{x:.2}, ±{y:.2}, ±{z:.2} mg along x, y, z ({chance})",
        advice "come into each attitude from both sides; hysteresis does not average down and part of it counts as scale factor";

    /// No misalignment matters.
    smaller_model_suffices(model: &str, largest: f64) =
        "smaller-model-suffices", [Note],
        what "the misalignments are negligible: model {model} would do",
        evidence "every misalignment with its U stays below {largest:.2} mrad",
        advice "fit `model = \"{model}\"`: three more degrees of freedom narrow the intervals";

    /// A standstill has another attitude than the one given for it.
    wrong_label(kind: &str, name: &str, place: &str, given: &str, seen: &str) =
        "wrong-label", [Decision],
        what "{kind} {name} has another attitude than its label states",
        evidence "{place}given {given}, the others see it along {seen}",
        advice "correct the attitude in the table of standstills, or leave the standstill out (`exclude` in [standstill])";

    /// A standstill contradicts the others.
    standstill_out_of_line(kind: &str, name: &str, place: &str, off: f64, chance: &str, residual: &str, exclusion: &str) =
        "standstill-out-of-line", [Warning],
        what "{kind} {name} is out of line",
        evidence "{place}{off:.2} mg off the others ({chance}); ‖a‖ − g = {residual} mm/s²",
        advice "look at the recording there; it was kept in the fit, and the result without it stands beside{exclusion}";

    /// Outputs follow other axes than those of their name.
    axes_swapped(axes: &str) =
        "axes-swapped", [Decision],
        what "the outputs follow other axes than they are named after",
        evidence "{axes}",
        advice "correct the columns, the wiring or the given attitudes and calibrate again; the compensation is right only for outputs in this very order";

    /// The sensitivity of an output is negative.
    axis_inverted(evidence: &str) =
        "axis-inverted", [Decision],
        what "an output falls where it should rise",
        evidence "{evidence}",
        advice "correct the wiring or the column, or the given attitudes (up and down exchanged), and calibrate again";

    /// The sensor is turned against the axes in which attitudes are given.
    frame_turned(rows: &str) =
        "frame-turned", [Decision],
        what "the axes of the sensor are far from those in which the attitudes are given",
        evidence "rows of K over their length: {rows}",
        advice "give the attitudes in the axes of the sensor; misalignments of this size are no small angles";

    /// Standstills of a validation lie beyond 0.1 % of g.
    beyond_one_per_mille(beyond: usize, standstills: usize, worst: &str, relative: f64, residual: f64, gravity: f64) =
        "beyond-one-per-mille", [Decision],
        what "{beyond} of {standstills} standstills miss the 0.1 % rule",
        evidence "worst is standstill {worst}: │‖a‖ − g│/g = {relative:.3} % ({residual:+.2} mm/s²)",
        advice "calibrate again, at the temperature of use; check that g = {gravity:.4} m/s² holds here";

    /// Residuals of a validation exceed their covariance.
    inconsistent_with_covariance(chi_squared: f64, dof: usize, p_value: f64) =
        "inconsistent-with-covariance", [Warning],
        what "the residuals are larger than the stated covariance explains",
        evidence "χ² = {chi_squared:.1} with {dof} degrees of freedom, probability {p_value:.1e}",
        advice "the sensor has moved since (temperature, time, mounting), or the standstills were not still",
        false_alarms "1 % of healthy validations, by the level of the test";

    /// The sensitivity is zero within its interval.
    no_response(sensitivity: f64, expanded: f64, unit: &str) =
        "no-response", [Decision],
        what "the output does not follow the position",
        evidence "sensitivity {sensitivity:.3e}, U = {expanded:.1e} {unit}",
        advice "look at the column, the wiring, and whether up and down are different recordings";

    /// Two axes are not at right angles.
    not_orthogonal(axes: &str, error: f64, acceleration: f64) =
        "not-orthogonal", [Note],
        what "{axes}: uncorrected, the axes read into each other",
        evidence "{error:.2} mg at {acceleration:.2} m/s²",
        advice "compensate with the whole matrix K, not with scale factors alone";

    /// Rising and falling readings differ.
    rising_and_falling(difference: f64, expanded: f64) =
        "rising-and-falling", [Warning],
        what "readings that were reached from below and from above differ: hysteresis, or a drift between both ways",
        evidence "{difference:.3} % ± {expanded:.3} % of full scale",
        advice "count half of it as half-width of a reading whose way is not known, and run the way twice: a drift does not repeat",
        false_alarms "1 % of healthy tests, by the level of the test";

    /// Which rest of a recording belongs to which angle is in doubt.
    angles_in_doubt(doubt: &str, evidence: &str) =
        "angles-in-doubt", [Decision],
        what "{doubt}",
        evidence "{evidence}",
        advice "compare the residuals with the list of angles; cut the recording into one file per angle (`files`) where rests are found at the wrong places",
        false_alarms "0.1 % of healthy recordings";

    /// Residuals over the angle of a table have a second harmonic.
    second_harmonic(percentage: f64, f: f64, limit: f64, found: f64) =
        "second-harmonic", [Warning],
        what "the residuals have a component of twice the angle: the output is not linear, or the axis of the table moves",
        evidence "{percentage:.3} % of the output at 1 g; F = {f:.1}, limit {limit:.1}; {found:.3} % is found in nine of ten tests",
        advice "test linearity with known accelerations, or turn the sensor by 180° on the table and repeat",
        false_alarms "0.5 % of healthy tests, by the level of the test";

    /// Residuals over the angle of a table have a third harmonic.
    third_harmonic(slope: f64, percentage: f64, f: f64, limit: f64, found: f64) =
        "third-harmonic", [Warning],
        what "the residuals go three times around with the angle: the output has a cube of the acceleration, and the sensitivity at zero is another",
        evidence "by {slope:.2} % where it is a cube; third harmonic {percentage:.3} % of the output at 1 g; F = {f:.1}, limit {limit:.1}; {found:.3} % is found in nine of ten tests",
        advice "state the sensitivity as that of ±1 g, or test linearity with the same readings against g cos θ",
        false_alarms "0.5 % of healthy tests, by the level of the test";

    /// The angles cannot show a cube of the acceleration.
    cubic_not_tested(readings: usize) =
        "cubic-not-tested", [Note],
        what "these angles cannot show a cubic nonlinearity: the sensitivity is that of ±1 g",
        evidence "{readings} readings; a cubic term of 0.1 % at 1 g changes the sensitivity at zero by 0.075 % to 0.1 %",
        advice "read ten angles or more in steps of 45° or less";

    /// Gravity is not along the axis that was named.
    gravity_elsewhere(axis: &str, outputs: &str) =
        "gravity-elsewhere", [Decision],
        what "the sensor does not read gravity along {axis}: another axis points up, or the unit is another",
        evidence "mean outputs: {outputs}",
        advice "name the axis that points up, the order of the columns and their unit";

    /// A quantity changes from calibration to calibration.
    calibration_drift(quantity: &str, drift: f64, expanded: f64, unit: &str) =
        "calibration-drift", [Warning],
        what "{quantity} drifts",
        evidence "{drift:.3e} ± {expanded:.1e} {unit} per month",
        advice "calibrate more often, or extrapolate the drift knowingly",
        false_alarms "1 % of healthy histories, over all quantities together";

    /// A quantity jumps between two calibrations.
    calibration_jump(quantity: &str, when: &str, height: f64, expanded: f64, unit: &str) =
        "calibration-jump", [Warning],
        what "{quantity} jumps {when}",
        evidence "{height:.3e} ± {expanded:.1e} {unit}, beside the drift",
        advice "look for a drop, a repair, another fixture or another reference between the two; a drift over the jump is not that of the device",
        false_alarms "at most 1 % of histories";

    /// The next calibration is due at once.
    tolerance_exhausted() =
        "tolerance-exhausted", [Decision],
        what "the uncertainty of the last calibration alone fills a tolerance",
        advice "calibrate better, or widen the tolerance";
}
