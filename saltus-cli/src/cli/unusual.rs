//! Warnings for numbers of flags that are out of their usual range.

use clap::ArgMatches;
use clap::parser::ValueSource;
use saltus::usual::{self, Range};

use crate::quantity;

/// A warning for each number on the command line that is out of its usual range.
pub(crate) fn warnings(matches: &ArgMatches) -> Vec<String> {
    let mut all = Vec::new();
    let mut here = Some(matches);
    while let Some(matches) = here {
        let flags = matches.ids().map(clap::Id::as_str);
        let typed = |id: &&str| matches.value_source(id) == Some(ValueSource::CommandLine);
        for id in flags.filter(typed) {
            let flag = id.replace('_', "-");
            let texts = matches.get_raw(id).into_iter().flatten();
            for text in texts.filter_map(|text| text.to_str()) {
                all.extend(warning(&flag, text));
            }
        }
        here = matches.subcommand().map(|(_, matches)| matches);
    }
    all
}

/// The warning for the first number of the flag's value `text` that is out of its usual range.
fn warning(flag: &str, text: &str) -> Option<String> {
    let ranges = usual::of_flag(flag);
    let written = format!("--{flag} {text}");
    numbers(ranges, text).find_map(|(range, number)| {
        let value = quantity::value(number, &range.quantity)?;
        range.warning(&written, number, value)
    })
}

/// The numbers of `text` and the range of each. One range is that of all numbers, of `start:stop:count` of
/// the two ends; several ranges are those of the numbers between colons, or without colons between commas.
fn numbers<'a>(
    ranges: &'static [Range],
    text: &'a str,
) -> impl Iterator<Item = (&'static Range, &'a str)> {
    let has_colon = text.contains(':');
    let parts = text.split(',').enumerate();
    parts.flat_map(move |(i, part)| {
        let words: Vec<&str> = part.split(':').collect();
        match ranges {
            [range] => words
                .into_iter()
                .take(2)
                .map(|word| (range, word))
                .collect(),
            _ if has_colon => ranges.iter().zip(words).collect(),
            _ => ranges
                .get(i)
                .map(|range| (range, part))
                .into_iter()
                .collect::<Vec<_>>(),
        }
    })
}

#[cfg(test)]
mod tests {
    use clap::{Command, CommandFactory};

    use super::*;
    use crate::cli::Cli;

    fn warned(line: &str) -> Vec<String> {
        let words = std::iter::once("saltus").chain(line.split(' '));
        warnings(&Cli::command().try_get_matches_from(words).expect(line))
    }

    #[test]
    fn a_number_out_of_its_usual_range_is_warned_of() {
        let check = |line: &str, warning: &str| assert_eq!(warned(line), [warning], "{line}");
        let rate = "the model is for 0 to 30 rad/s; is it in deg/s?";
        check(
            "simulate --omega 400 --alpha-f -0.1",
            &format!("--omega 400: {rate}"),
        );
        check(
            "table --omega 3:400:2 --distance 0.6",
            &format!("--omega 3:400:2: {rate}"),
        );
        check(
            "map --omega 5 --alpha-f -0.1,80deg",
            "--alpha-f -0.1,80deg: the model is for -1.2 to 1.2 rad",
        );
        check(
            "law --omega 3:6:5 --distance 600 --valve-open 0.1",
            "--distance 600: the model is for 0 to 30 m; is it in mm?",
        );
        check(
            "verify a.toml --valve-open 100",
            "--valve-open 100: the model is for 0 to 1 s; is it in ms?",
        );
        check(
            "verify a.csv --obstacle 0.4,0.1,210",
            "--obstacle 0.4,0.1,210: the model is for 0 to 10 m; is it in mm?",
        );
        check(
            "plan a.toml --share 0.9 --friction 0.3:30:3",
            "--friction 0.3:30:3: the model is for 0 to 3",
        );
        check(
            "run closed-loop --seconds 50000",
            "--seconds 50000: the model is for 0 to 3600 s; is it in ms?",
        );
        check(
            "run curve --knots 0:0.35:40ms,133:-0.1:40ms",
            &format!("--knots 0:0.35:40ms,133:-0.1:40ms: {rate}"),
        );
        check(
            "filling --omega 4 --alpha-f 0 --pause 700",
            "--pause 700: the model is for 0 to 600 s; is it in ms?",
        );
        for line in [
            "table --omega 3:6:61 --distance 0.6",
            "table --omega 3:6:400 --distance 0.6 --landing-height wheel --start-lean firing",
            "run curve --knots 0:0.35:40ms,13.3:-0.1:40ms",
        ] {
            assert_eq!(warned(line), [""; 0], "{line}");
        }
    }

    /// Flags whose domain is as narrow as their usual range, and numbers without one.
    const OTHERS: [&str; 9] = [
        "disturb",
        "heading",
        "law",
        "room",
        "share",
        "shift",
        "speed",
        "steepness",
        "step",
    ];

    /// Every flag of the commands that jump and run whose value is a number with a unit has a usual range.
    #[test]
    fn every_flag_with_a_number_has_a_usual_range() {
        fn flags(command: &Command, found: &mut Vec<(String, String)>) {
            let all = command.get_arguments().filter(|arg| !arg.is_positional());
            for arg in all {
                let names = arg.get_value_names().into_iter().flatten();
                let name = names
                    .map(clap::builder::Str::as_str)
                    .collect::<Vec<_>>()
                    .join(" ");
                found.push((arg.get_id().as_str().replace('_', "-"), name));
            }
            command.get_subcommands().for_each(|it| flags(it, found));
        }
        let commands = [
            "simulate", "table", "law", "map", "plan", "verify", "run", "filling", "jump",
        ];
        let words = [
            "RATE",
            "ANGLE",
            "TIME",
            "LENGTH",
            "HEIGHT",
            "COEFFICIENTS",
            "FACTOR",
            "MU",
            "LOW:HIGH",
        ];
        let mut found = Vec::new();
        for name in commands {
            let cli = Cli::command();
            flags(cli.find_subcommand(name).expect(name), &mut found);
        }
        found.retain(|(_, value)| words.iter().any(|word| value.contains(word)));
        // `jump --obstacle` has bounds of its own, in another form.
        found.retain(|(flag, value)| !(flag == "obstacle" && value.contains('x')));
        let bare = found.iter().map(|(flag, _)| flag.as_str());
        let bare: Vec<&str> = bare
            .filter(|flag| usual::of_flag(flag).is_empty() && !OTHERS.contains(flag))
            .collect();
        assert_eq!(bare, [""; 0]);
        assert!(found.len() > 40, "{}", found.len());
    }
}
