//! How help is laid out: commands in groups, options under headings, and with `-h` what a person needs first.
//!
//! The options are declared where they are used; here stands only where they are shown. An option without a row is shown
//! under `Options`.

use crate::Arguments;
use clap::builder::Resettable;
use clap::{Arg, Command, CommandFactory};
use std::fmt::Write as _;

/// A heading with the names that stand under it.
type Group = (&'static str, &'static [&'static str]);

/// The heading of options without one.
const OPTIONS: &str = "";

/// Groups of the commands of `proofmass`.
const COMMANDS: &[Group] = &[
    (
        "Calibrate",
        &[
            "calibrate",
            "init",
            "plan",
            "lab",
            "validate",
            "apply",
            "export",
            "import",
            "modes",
        ],
    ),
    ("Test", &["test", "compare", "device"]),
    ("Noise", &["noise", "bias", "filter"]),
    ("Velocity", &["velocity"]),
    ("Uncertainty", &["uncertainty"]),
    ("Certificates", &["certificate"]),
    #[cfg(feature = "records")]
    ("Records", &["records"]),
    (
        "Files and results",
        &[
            "inspect", "formats", "convert", "render", "explain", "verify", "keygen", "schema",
            "simulate",
        ],
    ),
    ("Shell", &["completions", "manual"]),
];

/// Groups of the commands of `proofmass test`.
const TESTS: &[Group] = &[
    (
        "By gravity, at rest",
        &[
            "sensitivity",
            "tilt",
            "zero-g",
            "orthogonality",
            "linearity",
            "centrifuge",
            "mounting",
            "temperature",
            "stability",
        ],
    ),
    (
        "Frequency response",
        &["random", "impact", "sweep", "steps", "model", "levels"],
    ),
    (
        "Shock and motion",
        &["shock", "step", "motion", "deconvolve"],
    ),
];

/// Headings of options, by the beginning of the command they belong to; the first row that fits counts.
const HEADINGS: &[(&str, &[Group])] = &[
    (
        "calibrate",
        &[(
            "A recording without a campaign",
            &[
                "latitude",
                "height",
                "gravity",
                "gravity-uncertainty",
                "columns",
                "unit",
                "time",
                "time-unit",
                "rate",
                "rows",
                "temperature",
                "model",
                "attitude-uncertainty",
                "a-true-uncertainty",
                "free-living",
            ],
        )],
    ),
    (
        "init",
        &[(
            "Place",
            &["latitude", "height", "gravity", "gravity-uncertainty"],
        )],
    ),
    (
        "velocity drift",
        &[
            (
                "Offset and inclination",
                &[
                    "offset",
                    "offset-uncertainty",
                    "offset-walk",
                    "tilt",
                    "tilt-uncertainty",
                ],
            ),
            ("Gain", &["gain-error", "gain-uncertainty", "speed"]),
            ("Noise", &["noise", "rate", "noise-density"]),
            (
                "From results",
                &["noise-result", "noise-channel", "calibration", "axis"],
            ),
            (
                "Aiding",
                &[
                    "rest",
                    "encoder-increment",
                    "encoder-rate",
                    "encoder-scale-uncertainty",
                    "encoder-walk",
                ],
            ),
        ],
    ),
    (
        "velocity integrator",
        &[
            ("Motion", &["band", "speed", "rate", "duration"]),
            ("Accelerometer", &["bias", "noise"]),
            ("Choice", &["error", "on-line"]),
        ],
    ),
    (
        "velocity",
        &[
            (
                "Encoder, resolver or wheel",
                &[
                    "columns",
                    "position",
                    "speed",
                    "quadrature",
                    "resolver",
                    "excitation",
                    "carrier",
                    "teeth",
                    "unit",
                    "scale",
                    "counts-per-turn",
                    "counts-per-metre",
                    "radius",
                    "lead",
                    "reverse",
                    "bits",
                    "gray",
                    "decoding",
                    "edges",
                    "angular",
                    "wraps",
                    "encoder-map",
                ],
            ),
            (
                "Two wheels beside a gyroscope",
                &["yaw-rate", "yaw-rate-unit", "track"],
            ),
            (
                "Accelerometer",
                &[
                    "acceleration",
                    "acceleration-unit",
                    "acceleration-file",
                    "acceleration-source",
                    "acceleration-time",
                    "acceleration-rate",
                    "calibration",
                    "calibration-band",
                    "axis",
                    "gain-uncertainty",
                    "latency",
                    "still",
                    "at-rest",
                    "initial-velocity",
                    "initial-velocity-uncertainty",
                ],
            ),
            (
                "Reference velocity",
                &[
                    "reference",
                    "reference-unit",
                    "reference-file",
                    "reference-time",
                    "reference-rate",
                    "reference-latency",
                ],
            ),
        ],
    ),
    (
        "noise",
        &[
            (
                "Curves and intervals",
                &[
                    "statistic",
                    "taus",
                    "detrend",
                    "probability",
                    "bias",
                    "edf",
                    "noise-type",
                    "segment",
                    "windows",
                    "separate",
                ],
            ),
            (
                "Fit of the coefficients",
                &[
                    "terms",
                    "gauss-markov",
                    "sinusoids",
                    "robust",
                    "report-terms",
                    "fix",
                    "highest-frequency",
                    "false-alarm-rate",
                    "temperature-lag",
                    "no-courses",
                ],
            ),
            ("Results", &["imu-yaml"]),
            ("Reading the recording", &["phase", "scale", "temperature"]),
        ],
    ),
    (
        "bias",
        &[
            (
                "Noise of the sensor",
                &["noise", "white", "walk", "markov", "initial"],
            ),
            (
                "Rests",
                &["up", "levelling", "segments", "threshold", "mean"],
            ),
        ],
    ),
    (
        "apply",
        &[
            (
                "Calibration over frequency",
                &["band", "filter", "hold", "coverage-factor"],
            ),
            (
                "What follows the calibration",
                &[
                    "bias",
                    "rotate",
                    "rotate-uncertainty",
                    "low-pass",
                    "linear-phase",
                    "decimate",
                    "attenuation",
                ],
            ),
            (
                "Acceleration back from one channel",
                &["dynamic", "model", "corner", "quiet"],
            ),
        ],
    ),
    (
        "test shock",
        &[
            (
                "Spectrum",
                &[
                    "frequencies",
                    "per-octave",
                    "quality",
                    "peaks",
                    "required-spectrum",
                    "spectrum-band",
                    "spectrum-rest",
                ],
            ),
            (
                "Nominal pulse",
                &[
                    "nominal",
                    "nominal-peak",
                    "nominal-duration",
                    "band",
                    "velocity-band",
                ],
            ),
            (
                "Reference",
                &[
                    "reference",
                    "reference-unit",
                    "reference-uncertainty",
                    "standard",
                    "standard-coverage-factor",
                    "standard-axis",
                    "standard-model",
                    "accept-unchecked-signature",
                ],
            ),
        ],
    ),
    (
        "simulate axis",
        &[
            (
                "Encoder",
                &[
                    "lines",
                    "radius",
                    "counter-bits",
                    "eccentricity",
                    "missing",
                    "every",
                ],
            ),
            (
                "Accelerometer",
                &[
                    "noise",
                    "offset",
                    "gain-error",
                    "latency",
                    "bits",
                    "orientation",
                    "roll-off",
                ],
            ),
        ],
    ),
    (
        "simulate noise",
        &[
            (
                "Coefficients",
                &[
                    "white",
                    "flicker",
                    "random-walk",
                    "quantisation",
                    "ramp",
                    "gauss-markov",
                    "sinusoid",
                ],
            ),
            (
                "Front end and disturbances",
                &[
                    "corner",
                    "order",
                    "outliers",
                    "outlier-size",
                    "step",
                    "gap",
                    "jitter",
                ],
            ),
        ],
    ),
    (
        "device plan",
        &[(
            "What is known before",
            &[
                "noise-result",
                "rate",
                "gravity-uncertainty",
                "reference-uncertainty",
                "temperature-range",
                "axes",
                "fixture-angle",
                "acceleration",
                "wander",
            ],
        )],
    ),
    ("simulate", &[(OPTIONS, &["rate"])]),
    ("filter", &[(OPTIONS, &["rate"])]),
    ("import", &[(OPTIONS, &["unit"])]),
    ("test model", &[(OPTIONS, &["unit"])]),
    (
        "",
        &[
            ("Results", &["output", "force", "sign", "json", "strict"]),
            (
                "Gravity",
                &["gravity", "gravity-uncertainty", "latitude", "height"],
            ),
            (
                "Reference standard",
                &[
                    "standard",
                    "standard-coverage-factor",
                    "standard-axis",
                    "standard-model",
                    "accept-unchecked-signature",
                ],
            ),
            (
                "Reading the recording",
                &[
                    "columns",
                    "unit",
                    "time",
                    "time-unit",
                    "rate",
                    "between",
                    "source",
                    "raw",
                    "rostopic",
                    "refuse-gaps",
                    "stream",
                    "segments",
                ],
            ),
        ],
    ),
];

/// Options that `-h` leaves to `--help`, by the beginning of the command.
const FOR_LATER: &[(&str, &[&str])] = &[
    (
        "",
        &["force", "sign", "contained", "strict", "source", "raw"],
    ),
    ("test temperature", &["tilt"]),
    ("device plan", &["fixture-angle"]),
    (
        "velocity estimate",
        &[
            "gain-uncertainty",
            "low-corner-uncertainty",
            "low-corner-order",
        ],
    ),
    (
        "velocity compare",
        &[
            "time-unit",
            "index",
            "gain-uncertainty",
            "low-corner-uncertainty",
            "low-corner-order",
        ],
    ),
    (
        "velocity tune",
        &[
            "gain-uncertainty",
            "low-corner-uncertainty",
            "low-corner-order",
        ],
    ),
    (
        "velocity map",
        &[
            "gain-uncertainty",
            "low-corner-uncertainty",
            "low-corner-order",
        ],
    ),
    (
        "velocity drift",
        &[
            "offset-walk",
            "noise-channel",
            "encoder-rate",
            "encoder-scale-uncertainty",
            "encoder-walk",
        ],
    ),
    (
        "velocity",
        &[
            "columns",
            "edges",
            "resolver",
            "excitation",
            "carrier",
            "teeth",
            "scale",
            "counts-per-metre",
            "lead",
            "reverse",
            "bits",
            "gray",
            "decoding",
            "angular",
            "wraps",
            "encoder-map",
            "yaw-rate",
            "yaw-rate-unit",
            "track",
            "acceleration-file",
            "acceleration-source",
            "acceleration-time",
            "acceleration-rate",
            "calibration",
            "calibration-band",
            "axis",
            "latency",
            "at-rest",
            "initial-velocity",
            "initial-velocity-uncertainty",
            "between",
            "reference-unit",
            "reference-time",
            "reference-rate",
            "reference-latency",
            "circumference",
            "skip",
            "known-increment",
            "quarters",
            "false-alarm-rate",
        ],
    ),
    (
        "noise",
        &[
            "scale",
            "phase",
            "robust",
            "temperature-lag",
            "no-courses",
            "detrend",
            "probability",
            "bias",
            "edf",
            "noise-type",
            "segment",
            "windows",
            "separate",
            "report-terms",
            "fix",
            "highest-frequency",
            "false-alarm-rate",
            "rostopic",
            "refuse-gaps",
            "stream",
        ],
    ),
    (
        "bias",
        &["white", "walk", "markov", "initial", "threshold", "mean"],
    ),
    (
        "apply",
        &[
            "time-unit",
            "at",
            "hold",
            "coverage-factor",
            "model",
            "corner",
            "quiet",
            "within-range",
            "rotate-uncertainty",
            "linear-phase",
            "attenuation",
        ],
    ),
    (
        "export",
        &["rotate-uncertainty", "linear-phase", "attenuation"],
    ),
    ("init", &["attitude-uncertainty", "a-true-uncertainty"]),
    ("uncertainty", &["check-digits", "effects"]),
    ("validate", &["threshold", "stream"]),
    ("test random", &["noise-ratio", "input-unit", "output-unit"]),
    ("test impact", &["noise-ratio", "force-window"]),
    (
        "test shock",
        &[
            "return-band",
            "per-octave",
            "quality",
            "band",
            "required-spectrum",
            "reference-unit",
            "standard",
            "peaks",
            "velocity-band",
            "spectrum-band",
            "spectrum-rest",
        ],
    ),
    (
        "test",
        &[
            "standard-coverage-factor",
            "standard-axis",
            "standard-model",
            "accept-unchecked-signature",
            "reference-frequency",
            "sensitivity-uncertainty",
        ],
    ),
    (
        "simulate axis",
        &[
            "eccentricity",
            "missing",
            "every",
            "orientation",
            "roll-off",
            "counter-bits",
            "bits",
        ],
    ),
    (
        "simulate noise",
        &[
            "corner",
            "order",
            "outliers",
            "outlier-size",
            "step",
            "gap",
            "jitter",
        ],
    ),
];

/// What a file of arguments is, below each long help.
const ARGUMENT_FILES: &str = "Arguments that are used again can stand in a file, one option with its value to a line, `#` before comments:\n\
                              proofmass COMMAND @FILE. A value may stand in quotes.";

/// The command line, laid out.
pub(crate) fn command() -> Command {
    let root = laid_out(Arguments::command(), "");
    let tests = root
        .find_subcommand("test")
        .map(|test| overview(test, TESTS));
    let root = match tests {
        Some(text) => root.mut_subcommand("test", |test| with_groups(test, &text)),
        None => root,
    };
    let text = overview(&root, COMMANDS);
    with_groups(root, &text)
        .after_help("`proofmass COMMAND -h` shows what is needed first, `--help` everything. `proofmass explain WORD` explains a word of the field (Allan, VRW, SRS, …) or a finding.")
}

/// Headings, and what waits for `--help`, of a command and those below it.
fn laid_out(command: Command, path: &str) -> Command {
    let mut later = 0;
    let command = command.mut_args(|argument| {
        let argument = with_brief(argument);
        let Some(name) = argument.get_long().map(str::to_owned) else {
            return argument;
        };
        let argument = match heading(path, &name) {
            Some(OPTIONS) | None => argument.help_heading(Resettable::Reset),
            Some(heading) => argument.help_heading(heading),
        };
        // What few recordings need says so itself, wherever it stands.
        let waits = !argument.is_required_set()
            && (argument.is_hide_short_help_set() || waits(path, &name));
        later += usize::from(waits);
        argument.hide_short_help(waits)
    });
    let command = match (later, path) {
        (_, "") => command,
        (0, _) => command.after_long_help(ARGUMENT_FILES),
        (n, _) => command
            .after_help(format!(
                "`--help` explains {n} more option{}; @FILE stands for arguments in a file.",
                if n == 1 { "" } else { "s" }
            ))
            .after_long_help(ARGUMENT_FILES),
    };
    command.mut_subcommands(|below| {
        let name = below.get_name().to_owned();
        let path = [path, &name].join(" ");
        laid_out(below, path.trim_start())
    })
}

/// With the first phrase of a long text for `-h`; `--help` keeps all of it.
fn with_brief(argument: Arg) -> Arg {
    let whole = argument.get_help().map(ToString::to_string);
    let Some((whole, brief)) = whole.and_then(|whole| {
        let brief = brief(&whole)?;
        Some((whole, brief))
    }) else {
        return argument;
    };
    match argument.get_long_help() {
        Some(_) => argument.help(brief),
        None => argument.help(brief).long_help(whole),
    }
}

/// A text up to the last mark that leaves a line of it, where it is longer than a line.
fn brief(text: &str) -> Option<String> {
    const LINE: usize = 60;
    const PHRASE: usize = 30;
    if text.chars().count() <= LINE {
        return None;
    }
    let cut = |marks: &[&str]| {
        let ends = marks.iter().flat_map(|mark| text.match_indices(mark));
        let ends = ends.map(|(at, _)| at);
        let ends = ends.filter(|at| (PHRASE..=LINE).contains(at) && is_balanced(&text[..*at]));
        ends.max().map(|at| &text[..at])
    };
    match cut(&["; ", ": ", " [", " ("]) {
        Some(phrase) => Some(phrase.to_owned()),
        None => cut(&[", "]).map(|part| format!("{part}, …")),
    }
}

/// Whether every bracket of a text is closed.
fn is_balanced(text: &str) -> bool {
    let count = |c: char| text.matches(c).count();
    count('(') == count(')') && count('[') == count(']')
}

/// Whether a row that begins so is about a command.
fn is_about(beginning: &str, path: &str) -> bool {
    let rest = path.strip_prefix(beginning);
    rest.is_some_and(|rest| beginning.is_empty() || rest.is_empty() || rest.starts_with(' '))
}

fn heading(path: &str, name: &str) -> Option<&'static str> {
    let mut rows = HEADINGS
        .iter()
        .filter(|(beginning, _)| is_about(beginning, path));
    rows.find_map(|(_, groups)| {
        let group = groups.iter().find(|(_, names)| names.contains(&name));
        group.map(|(heading, _)| *heading)
    })
}

fn waits(path: &str, name: &str) -> bool {
    let mut rows = FOR_LATER.iter();
    rows.any(|(beginning, names)| is_about(beginning, path) && names.contains(&name))
}

/// The commands below one, in their groups.
fn overview(command: &Command, groups: &[Group]) -> String {
    let width = command.get_subcommands().map(|c| c.get_name().len()).max();
    let width = width.unwrap_or_default();
    let mut text = String::new();
    for (heading, names) in groups {
        let _ = writeln!(text, "\x1b[1m\x1b[4m{heading}:\x1b[0m");
        for name in *names {
            let about = command.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(text, "  \x1b[1m{name:width$}\x1b[0m  {about}");
        }
        text.push('\n');
    }
    text
}

fn with_groups(command: Command, overview: &str) -> Command {
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{overview}\x1b[1m\x1b[4mOptions:\x1b[0m\n{{options}}{{after-help}}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_first_phrases_of_long_texts() {
        let text = "Column of the position (count, length or angle); of several columns the mean, as of two wheels";
        let phrase = "Column of the position (count, length or angle)";
        assert_eq!(brief(text).as_deref(), Some(phrase));
        assert_eq!(brief("Column of the device"), None);
        let list = "Shaker campaigns: coverage factor of U, such as 2; its probability is stated, 95 % otherwise";
        assert_eq!(
            brief(list).as_deref(),
            Some("Shaker campaigns: coverage factor of U, such as 2")
        );
        let default = "Folder for result.json, report.html and tables [default: none is written]";
        assert_eq!(
            brief(default).as_deref(),
            Some("Folder for result.json, report.html and tables")
        );
    }

    /// Every command with its path.
    fn all(command: &Command, path: &str, found: &mut Vec<(String, Command)>) {
        for below in command.get_subcommands() {
            let path = [path, below.get_name()].join(" ");
            found.push((path.trim().to_owned(), below.clone()));
            all(below, &path, found);
        }
    }

    fn every_command() -> Vec<(String, Command)> {
        let mut found = Vec::new();
        all(&command(), "", &mut found);
        found
    }

    #[test]
    fn law_every_command_stands_in_one_group() {
        let root = command();
        let test = root.find_subcommand("test").expect("a command");
        for (command, groups) in [(&root, COMMANDS), (test, TESTS)] {
            let mut shown: Vec<&str> = groups
                .iter()
                .flat_map(|(_, names)| names.iter().copied())
                .collect();
            let mut names: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
            shown.sort_unstable();
            names.sort_unstable();
            assert_eq!(shown, names);
        }
    }

    #[test]
    fn law_every_command_and_option_has_its_help() {
        for (path, command) in every_command() {
            assert!(command.get_about().is_some(), "{path}");
            let shown = command.get_arguments().filter(|a| !a.is_hide_set());
            for argument in shown {
                let help = argument.get_help().map(ToString::to_string);
                let told = help.is_some_and(|h| !h.trim().is_empty());
                assert!(told, "{path}: {}", argument.get_id());
            }
        }
    }

    #[test]
    fn law_every_row_of_the_layout_names_an_option_that_exists() {
        let commands = every_command();
        let has = |beginning: &str, name: &str| {
            let mut fit = commands
                .iter()
                .filter(|(path, _)| is_about(beginning, path));
            fit.any(|(_, c)| c.get_arguments().any(|a| a.get_long() == Some(name)))
        };
        let headings = HEADINGS.iter().flat_map(|(b, groups)| {
            groups
                .iter()
                .flat_map(move |(_, n)| n.iter().map(move |n| (b, n)))
        });
        let later = FOR_LATER
            .iter()
            .flat_map(|(b, names)| names.iter().map(move |n| (b, n)));
        for (beginning, name) in headings.chain(later) {
            assert!(
                has(beginning, name),
                "no command {beginning:?} has --{name}"
            );
        }
    }

    #[test]
    fn law_short_help_is_short_and_long_help_is_whole() {
        let mut longer = Vec::new();
        for (path, mut command) in every_command() {
            let short = command.render_help().to_string();
            let lines = short.lines().count();
            if lines > 40 {
                longer.push(format!("{path}: {lines} lines\n{short}"));
            }
            let long = command.render_long_help().to_string();
            for argument in command.get_arguments().filter_map(Arg::get_long) {
                assert!(
                    long.contains(&format!("--{argument}")),
                    "{path}: {argument}"
                );
            }
        }
        assert!(longer.is_empty(), "{}", longer.join("\n\n"));
    }

    #[test]
    fn law_the_coverage_factor_is_one_option() {
        for (path, command) in every_command() {
            let argument = command
                .get_arguments()
                .find(|a| a.get_long() == Some("coverage-factor"));
            let Some(argument) = argument else { continue };
            assert_eq!(argument.get_short(), Some('k'), "{path}");
            assert_eq!(argument.get_all_aliases(), Some(vec!["coverage"]), "{path}");
        }
    }
}
