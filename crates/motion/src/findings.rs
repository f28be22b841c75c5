//! Every finding of the motion room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What the estimation of velocity and its decoders may find.
    pub CATALOGUE;

    /// The position or the speed has one value throughout.
    readings_never_change(cause: &str, value: f64, readings: usize, details: &str) =
        "readings-never-change", [Decision],
        what "the readings never change: {cause}",
        evidence "{value} in all {readings} readings{details}",
        advice "check column and cable if the axis moved; nothing can be tuned on a standstill";

    /// Readings are missing where one was due.
    missing_readings(missing: usize, due: usize) =
        "missing-readings", [Note],
        what "readings are missing",
        evidence "{missing} of {due} readings missing",
        advice "fused methods integrate the acceleration there; the uncertainty grows with it";

    /// Time stamps scatter about the clock of the samples.
    stamps_scatter(scatter: f64, share: f64) =
        "stamps-scatter", [Note],
        what "the time stamps scatter and the positions do not show it: the even clock behind them was used",
        evidence "{scatter:.4} ms about it, {share:.1} % of a step",
        advice "where the samples themselves are uneven, move the axis faster in a recording: positions at true stamps are then the smoother ones";

    /// The first readings contradict the stated initial velocity.
    start_in_motion(found: f64, known: f64, stated: f64) =
        "start-in-motion", [Decision],
        what "the record does not start at the stated velocity",
        evidence "{found:.4} by the first readings, stated {stated:.4}; {known:.4} is the standard uncertainty of the difference",
        advice "leave the initial velocity unknown, or state it with its uncertainty";

    /// The acceleration is not constant in the stretch that is stated as still.
    still_stretch_moves(scatter: f64, ratio: f64, offset: f64) =
        "still-stretch-moves", [Warning],
        what "the acceleration changes in the interval that is stated as at rest",
        evidence "means of a tenth of it scatter by {scatter:.2e} m/s², {ratio:.0} times what its noise explains; the offset is uncertain by {offset:.2e} m/s², which makes {offset:.2e} m/s in a second",
        advice "choose an interval in which the axis rests, or one long enough for vibration to average";

    /// Rounding is correlated with the motion.
    rounding_repeats(found: f64, rounding: f64) =
        "rounding-repeats", [Note],
        what "the readings fit better than their increment allows: its rounding repeats with the motion, and the noise of a reading was set to it",
        evidence "found {found:.2e}, increment over the root of twelve {rounding:.2e}",
        advice "choose a sampling rate that is no multiple of the motion's frequency, so that the rounding averages";

    /// The likelihood rises up to the end of the searched range.
    likelihood_at_bound(ratio: f64, lowest: f64, highest: f64) =
        "likelihood-at-bound", [Warning],
        what "one sensor is ignored: the likelihood has no maximum inside the searched range",
        evidence "log10(q T^4/R) = {ratio:.1}, searched from {lowest:.1} to {highest:.1}; q is the noise density of the acceleration, T the sampling interval, R the variance of a reading",
        advice "check that both sensors move, and that unit and sign of both agree";

    /// The axis stays on one increment for long stretches.
    slow_quantised_readings(fraction: f64, run: usize) =
        "slow-quantised-readings", [Note],
        what "the readings keep one value for long times: they were used at the edges, where they change",
        evidence "{fraction:.0} % of the readings lie in runs of {run} and more equal ones",
        advice "record the times of the edges: they determine the motion better where the axis is slow";

    /// A count or an angle jumps by its whole range.
    rollover_suspected(jump: &str, from: f64, to: f64, remedy: &str) =
        "rollover-suspected", [Decision],
        what "the {jump}",
        evidence "from {from} to {to}",
        advice "{remedy}";

    /// The velocity is proportional to the reference with a factor that is not one.
    reference_scale(deviation: f64, sense: &str, scale: f64, lower: f64, upper: f64, delay: f64, delay_uncertainty: f64, rms: f64) =
        "reference-scale", [Warning],
        what "the velocity is {deviation:.2} % {sense} compared with the reference",
        evidence "scale {scale:.5} (95 %: {lower:.5} to {upper:.5}) at a delay of {delay:.1} ms (u = {delay_uncertainty:.1} ms); {rms:.4} m/s RMS are left of the difference",
        advice "check the radius of the wheel, the increment and the unit: one of them is wrong by this factor, if the reference is right",
        false_alarms "2 of 696 records of healthy axes";

    /// The reference has a delay of its own.
    reference_delay(sense: &str, delay: f64, uncertainty: f64) =
        "reference-delay", [Warning],
        what "the reference is {sense}: every fused velocity differs from it by the same time",
        evidence "{delay:.1} ms (u = {uncertainty:.1} ms)",
        advice "state this time as the latency of the reference; otherwise the errors are mostly its delay";

    /// Methods were compared without a true velocity.
    smoother_as_reference() =
        "smoother-as-reference", [Note],
        what "no true velocity was given: errors are differences from the smoother at the full rate",
        advice "an error common to both sensors does not show";

    /// A thinned record is too short for tuning.
    not_tuned(rate: &str, reason: &str) =
        "not-tuned", [Note],
        what "the record is too short to tune at this rate",
        evidence "{rate} Hz: {reason}";

    /// The motion by the readings is not as large as that by the accelerometer. A note where the gain was estimated and is used, and
    /// lies within the tolerance of accelerometers.
    gain_mismatch(treatment: &str, gain: f64, uncertainty: f64, details: &str) =
        "gain-mismatch", [Warning, Decision, Note],
        what "the accelerometer shows {gain:.4} times the motion of the readings{treatment}",
        evidence "{details}: {gain:.5} (u = {uncertainty:.5})",
        advice "calibrate the accelerometer, or check units, axis, increment and radius of the wheel: one of them is wrong by this factor";

    /// Readings and accelerometer are shifted in time. A note where the shift was estimated and is used.
    latency(sense: &str, treatment: &str, latency: f64, uncertainty: f64, details: &str) =
        "latency", [Warning, Note],
        what "the accelerometer is {sense} than the readings{treatment}",
        evidence "{latency:.4} ms (u = {uncertainty:.4} ms){details}",
        advice "state this time, or shift the accelerometer by it; methods that run on line do not estimate it";

    /// The tuning used a part of the record.
    tuned_on_a_part(from: f64, to: f64, duration: f64) =
        "tuned-on-a-part", [Note],
        what "the noise was estimated from a part: the longest without slip, of a long record the one with most motion",
        evidence "{from:.3} s to {to:.3} s of {duration:.3} s";

    /// The encoder deviates periodically.
    encoder_ripple(periods: &str) =
        "encoder-ripple", [Note],
        what "the encoder has errors that repeat with the position",
        evidence "{periods}",
        advice "an eccentric disc or wheel repeats once per turn, a gear once per its turn: map and subtract the error, or set the crossover below its frequency";

    /// The encoder deviates once or twice per turn.
    encoder_map_subtracted(lines: &str) =
        "encoder-map-subtracted", [Note],
        what "the encoder has errors that repeat every turn, as of an eccentric disc; they were found beside the accelerometer and subtracted",
        evidence "{lines}",
        advice "map the encoder once by `velocity map` and state the result by --encoder-map",
        false_alarms "at most 1 of 1000 recordings by its test";

    /// The accelerometer is slower than the rows.
    accelerometer_held(rows: usize, rate: f64) =
        "accelerometer-held", [Note],
        what "the accelerometer is slower than the rows: each of its values stands in several; the rows with a new one are used",
        evidence "every value stands in {rows} rows; {rate:.1} new ones a second",
        advice "record the accelerometer at its own rate in a file of its own (--acceleration-file), or the rows at that rate",
        false_alarms "none where values change as they like: 98 % of fifty changes would have to come in step";

    /// The accelerometer shows less of slow accelerations.
    low_corner_found(frequency: f64, uncertainty: f64, time: f64) =
        "low-corner-found", [Warning],
        what "the accelerometer shows less and less of slow accelerations, as a piezoelectric one or an AC coupling does; its corner of {frequency:.4} Hz was found beside the readings and is used",
        evidence "corner of first order at {frequency:.4} Hz (u = {uncertainty:.4} Hz), a time constant of {time:.3} s",
        advice "state the corner of the data sheet or of a calibration (--low-corner HZ), or take an accelerometer that measures down to zero; of two stages, as a charge amplifier before an AC coupling, the corner has to be stated: --low-corner HZ --low-corner-order 2",
        false_alarms "at most 1 of 1000 recordings by its test";

    /// The accelerometer adds nothing but its noise.
    encoder_alone(gained: f64, alone: f64, fused: f64) =
        "encoder-alone", [Note],
        what "the motion is smaller than the noise of the accelerometer: the velocity is that of the encoder alone",
        evidence "the log-likelihood of the readings is higher by {gained:.0} without the accelerometer; standard uncertainty {alone:.2e} alone, {fused:.2e} with both",
        advice "with --method kalman:Q,R both sensors are used";

    /// Encoder and accelerometer disagree for a short time.
    slip(from: f64, to: f64, window: f64, change: f64, deviations: f64, quiet: f64, others: &str) =
        "slip", [Warning],
        what "encoder and accelerometer do not measure the same motion",
        evidence "{from:.3} s to {to:.3} s: velocity change over {window:.0} ms differs by {change:.4} ({deviations:.1} standard deviations of the quiet part, {quiet:.4}){others}",
        advice "the wheel slips, the coupling yields, or the accelerometer feels a rotation; the fused velocity is not valid there";

    /// Slip, or gain and latency: the record does not decide.
    slip_in_doubt(gain: f64, latency: f64, gained: f64) =
        "slip-in-doubt", [Warning],
        what "encoder and accelerometer differ, and the record does not decide between slip and an error of gain and latency",
        evidence "a gain of {gain:.4} and a latency of {latency:.2} ms instead of slip change the log-likelihood by {gained:+.1}, with the penalty for the extra parameters subtracted",
        advice "state the latency or the uncertainty of the gain, or record a motion with other accelerations";

    /// A strong deceleration against the motion.
    collision(from: f64, to: f64, change: f64, window: f64, deviations: f64, others: &str) =
        "collision", [Warning],
        what "an impact stopped the axis: a strong deceleration against the motion",
        evidence "{from:.3} s to {to:.3} s: velocity change {change:.4} within {window:.0} ms ({deviations:.1} standard deviations){others}",
        advice "check the range and bandwidth of the accelerometer; what it may have missed of the impact is in the uncertainty";

    /// Both channels of an incremental encoder changed at once.
    illegal_transitions(transitions: usize, samples: usize, first: usize) =
        "illegal-transitions", [Warning],
        what "both encoder channels changed between two samples",
        evidence "{transitions} illegal transitions in {samples} samples, the first at sample {first}; each may stand for two lost quarters",
        advice "sample faster than four times the line frequency, or check the encoder's supply and cable";

    /// Turns have different numbers of counts.
    unequal_turns(least: i64, most: i64) =
        "unequal-turns", [Warning],
        what "the counts between index pulses are not equal",
        evidence "{least} to {most} counts between index pulses",
        advice "counts were lost or the axis turned back between pulses; set the count to zero at every index";

    /// The counts have their zero at the index pulse.
    zero_at_index(pulses: usize, first: f64) =
        "zero-at-index", [Note],
        what "the zero of the position is where the index pulse begins",
        evidence "{pulses} pulses, the first at {first:.3} s";

    /// Counts were lost or added between two index pulses and put back.
    counts_put_back(counts: i64, turns: usize, intervals: usize, list: &str) =
        "counts-put-back", [Warning],
        what "counts were lost or added between index pulses, and were put back",
        evidence "{counts} counts in {turns} of {intervals} intervals between pulses: {list}",
        advice "check supply, cable and largest speed of the encoder; within such a turn the position may be off by that number",
        false_alarms "0 of 1000 records of healthy axes";

    /// Turns by the index have another number of counts than is stated.
    index_turn_mismatch(found: i64, stated: i64) =
        "index-turn-mismatch", [Decision],
        what "a turn by the index has another number of counts than is stated; nothing was put back",
        evidence "{found} counts to a turn, stated {stated}",
        advice "state the counts of a turn after decoding, four times the lines with fourfold decoding; or name the column of the index";

    /// No index pulse came.
    no_index(state: &str) =
        "no-index", [Warning],
        what "the index does not change: the zero of the position is that of the first sample",
        evidence "it is {state} high",
        advice "check the column of the index, or move the axis by more than a turn";

    /// The index is high everywhere but over its pulse.
    index_inverted() =
        "index-inverted", [Note],
        what "the index is low over its pulse and high elsewhere: it is taken the other way round",
        advice "nothing has to be done; the two lines of the index are exchanged, or the reader inverts";

    /// The index lags behind the counts.
    index_late(samples: usize) =
        "index-late", [Note],
        what "the index comes {samples} samples after the counts; this delay is corrected, so that pulses in both directions agree",
        advice "remove the filter from the index line, or read it with the channels";

    /// An absolute encoder moves far between two samples.
    large_step(step: i64, range: u64) =
        "large-step", [Warning],
        what "the count moves by more than a quarter of its range between two samples",
        evidence "largest step {step} of a range of {range}",
        advice "beyond half the range the direction is lost: sample faster or use a wider counter";

    /// A speed sensor does not resolve slow motion.
    speed_threshold(threshold: f64, left_out: usize, readings: usize, around: f64) =
        "speed-threshold", [Note],
        what "the sensor reads zero below a threshold speed: its zeros next to a motion were left out",
        evidence "no reading between 0 and {threshold:.4}; {left_out} of {readings} readings, those within {around} s of a motion",
        advice "the accelerometer bridges them; the uncertainty grows with it";

    /// The encoder was recorded over a part of a turn.
    encoder_map_part_of_a_turn(turns: f64) =
        "encoder-map-part-of-a-turn", [Warning],
        what "the recording covers less than a turn: elsewhere the map is an extrapolation",
        evidence "{turns:.2} turns",
        advice "turn the axis through two turns or more, in both senses";

    /// The intervals of filter and smoother overlap too rarely.
    filter_and_smoother_disagree(fraction: f64) =
        "filter-and-smoother-disagree", [Warning],
        what "filter and smoother differ by more than their uncertainties allow",
        evidence "{fraction:.1} % of the samples away from slip agree within two standard uncertainties; 95 % are expected",
        advice "tune on this record, or look for slip, latency and gain errors; of an accelerometer with a low corner also for another frequency or another order (--low-corner, --low-corner-order)";

    /// Sine and cosine of a resolver do not lie on a circle.
    resolver_amplitude(least: f64, most: f64) =
        "resolver-amplitude", [Warning],
        what "the amplitude of the resolver is not constant",
        evidence "amplitude from {least:.4} to {most:.4} V",
        advice "unequal windings, offsets or a failing excitation: the angle is wrong by up to half the relative difference; an encoder map of orders 1 and 2 finds what repeats";

    /// The resolver has no signal.
    resolver_signal_lost(lost: usize, samples: usize, usual: f64, first: usize) =
        "resolver-signal-lost", [Warning],
        what "the resolver has no signal for a while: the velocity is estimated without readings there",
        evidence "{lost} of {samples} samples below a third of the usual amplitude of {usual:.4} V, the first is sample {first}",
        advice "check windings, connectors and the excitation";

    /// Single readings or samples of the accelerometer are outliers.
    glitches(which: &str, treatment: &str, count: usize, all: usize, first: usize, largest: f64, ratio: f64) =
        "glitches", [Warning],
        what "single {which} are outliers of the motion and were left out{treatment}",
        evidence "{count} of {all}; the first at sample {first}; off by up to {largest:.3e}, {ratio:.0} times their scatter",
        advice "look for a word that is read while it changes, a flipped bit, or a disturbed cable";

    /// Readings and accelerometer have opposite signs.
    opposite_sense(gain: f64, uncertainty: f64, correlation: f64, window: f64) =
        "opposite-sense", [Decision],
        what "readings and accelerometer are positive in opposite senses",
        evidence "velocity changes of the accelerometer over those of the readings: {gain:.4} (u = {uncertainty:.4}), correlation {correlation:.3}, windows of {window:.3} s",
        advice "reverse the readings: --reverse";

}
