//! The commands that the documents name.

/// The commands that a document names in its sentences, tables and blocks, as their words.
///
/// Not those without arguments, which only name a command, nor forms, whose words in capitals stand
/// for something else.
pub(crate) fn named(document: &str) -> Vec<Vec<String>> {
    const COMMANDS: &str = "simulate table law map plan verify filling run jump diagnose design inject fit export c rust gait disc-stable mjcf urdf";
    let in_blocks = document.lines().filter_map(|line| {
        let line = line.strip_prefix("$ ").unwrap_or(line);
        line.trim_start().strip_prefix("saltus ")
    });
    let text = document.replace('\n', " ");
    let in_text = text.split("`saltus ").skip(1);
    let in_text = in_text.filter_map(|rest| Some(rest.split_once('`')?.0));
    let words = |line: &str| {
        line.split_whitespace()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let is_form = |word: &str| {
        let capitals = word.split(|c: char| !c.is_ascii_uppercase());
        word.contains('…') || capitals.into_iter().any(|part| part.len() > 2)
    };
    in_blocks
        .chain(in_text)
        .map(words)
        .filter(|words| !words.iter().any(|word| is_form(word)))
        .filter(|words| {
            words
                .iter()
                .any(|word| !COMMANDS.split(' ').any(|name| name == word))
        })
        .collect()
}
