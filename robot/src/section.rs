//! Reading one table of a TOML file key by key: typed, checked, in any of a quantity's units, with no
//! key left over.
//!
//! ```
//! use saltus_robot::domain::Domain;
//! use saltus_robot::section::Section;
//! use saltus_robot::units::LENGTH;
//!
//! let mut file = Section::file("[[obstacle]]\nhight_mm = 120", "course.toml")?;
//! let mut boxes = file.tables("obstacle", 64);
//! file.finish(())?;
//! let height = boxes[0].number("height", LENGTH, Domain::POSITIVE);
//! let error = boxes.remove(0).finish(height).unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "course.toml:2: unknown key obstacle 1.hight_mm; the nearest known key is obstacle 1.height_mm",
//! );
//! # Ok::<(), saltus_robot::RobotError>(())
//! ```

use crate::document::{self, Node, Table, Value, join};
use crate::domain::Domain;
use crate::units::{Quantity, Unit};
use crate::{Place, RobotError};

/// A table being read.
///
/// Reading takes keys out and goes on after the first problem, with a stand-in such as NaN;
/// [`Section::finish`] then lets nothing out. So an unknown key, which is mostly a misspelt one, is
/// reported before the key that it leaves missing.
pub struct Section {
    /// Dotted key; empty for the whole file.
    path: String,
    place: Place,
    entries: Table,
    /// Keys requested so far, all spellings of one thing together.
    known: Vec<Vec<String>>,
    /// Numbers read so far: each key without its unit, how messages name it, the value as written and in SI.
    numbers: Vec<Number>,
    problem: Option<RobotError>,
}

/// A number that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Key in its table, without the unit.
    pub stem: String,
    /// Dotted key with its unit, and the item of a list.
    pub name: String,
    /// The value as written.
    pub source: String,
    /// The value (SI).
    pub value: f64,
    /// Where it stands.
    pub place: Place,
}

impl Section {
    /// The file `text`, which messages call `file`.
    ///
    /// # Errors
    /// [`RobotError::NotToml`].
    pub fn file(text: &str, file: &str) -> Result<Section, RobotError> {
        Section::new(String::new(), document::parse(text, file)?)
    }

    /// Its dotted key.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// Where the table begins.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The table `node`, whose dotted key is `path`.
    pub(crate) fn new(path: String, node: Node) -> Result<Section, RobotError> {
        let Node {
            place,
            source,
            value,
        } = node;
        match value {
            Value::Table(entries) => Ok(Section {
                path,
                place,
                entries,
                known: Vec::new(),
                numbers: Vec::new(),
                problem: None,
            }),
            _ => Err(RobotError::NotAllowed {
                place,
                key: path,
                value: source,
                allowed: "a table".into(),
            }),
        }
    }

    /// `read`, unless a key is left or there was a problem.
    ///
    /// # Errors
    /// [`RobotError`]: the unknown key that stands first, or else the first problem.
    pub fn finish<T>(mut self, read: T) -> Result<T, RobotError> {
        self.check_keys(&[])?;
        self.stop_at_problem().map(|()| read)
    }

    /// Refuses a key that was not asked for and is none of `others`: for tables whose keys depend on
    /// one of them.
    ///
    /// # Errors
    /// [`RobotError::UnknownKey`]: the one that stands first.
    pub fn check_keys(&mut self, others: &[&str]) -> Result<(), RobotError> {
        self.known
            .extend(others.iter().map(|other| vec![other.to_string()]));
        let unknown = |(key, _): &(&String, &Node)| !others.contains(&key.as_str());
        let left = self.entries.iter().filter(unknown);
        let Some((key, node)) = left.min_by_key(|(_, node)| &node.place) else {
            return Ok(());
        };
        let nearest = self
            .known
            .iter()
            .flatten()
            .min_by_key(|known| edits(known, key))
            .filter(|known| is_near(known, key));
        let mut allowed: Vec<String> = Vec::new();
        for spelling in self.known.iter().filter_map(|keys| keys.first()) {
            if !allowed.contains(spelling) {
                allowed.push(spelling.clone());
            }
        }
        Err(RobotError::UnknownKey {
            place: node.place.clone(),
            key: self.dotted(key),
            nearest: nearest.map(|nearest| self.dotted(nearest)),
            allowed,
        })
    }

    /// The numbers read so far.
    pub fn numbers_read(&self) -> &[Number] {
        &self.numbers
    }

    /// The first problem so far, for readers that rest on what was read before.
    ///
    /// # Errors
    /// That problem.
    pub fn stop_at_problem(&mut self) -> Result<(), RobotError> {
        self.problem.take().map_or(Ok(()), Err)
    }

    /// The number `stem` in SI, in whichever of its units it is given.
    pub fn number(&mut self, stem: &str, quantity: Quantity, domain: Domain) -> f64 {
        self.one_of(&[(stem, quantity, domain)]).1
    }

    /// The number `stem` in SI, if given.
    pub fn optional(&mut self, stem: &str, quantity: Quantity, domain: Domain) -> Option<f64> {
        self.optional_one_of(&[(stem, quantity, domain)])
            .map(|(_, number)| number)
    }

    /// Which of several ways to give a number was taken, and the number in SI.
    pub fn one_of(&mut self, ways: &[Way]) -> (usize, f64) {
        self.optional_one_of(ways).unwrap_or_else(|| {
            let (keys, _) = spellings(ways);
            self.missing(&keys, "");
            (0, f64::NAN)
        })
    }

    fn optional_one_of(&mut self, ways: &[Way]) -> Option<(usize, f64)> {
        let (key, way, unit, node) = self.spelled(ways)?;
        let (stem, quantity, domain) = ways[way];
        let name = self.dotted(&key);
        Some((way, self.si(stem, name, node, (unit, quantity, domain))))
    }

    /// One number `stem` for all of `count` things, or a list with one for each (SI).
    pub fn numbers(
        &mut self,
        stem: &str,
        quantity: Quantity,
        domain: Domain,
        count: usize,
    ) -> Vec<f64> {
        self.one_or_list(stem, quantity, domain, |given| {
            (given != count)
                .then(|| format!("one number, or a list of {count}; this list has {given}"))
        })
    }

    /// A list of numbers `stem` (SI), of any length above 0; one number is a list of one.
    pub fn list(&mut self, stem: &str, quantity: Quantity, domain: Domain) -> Vec<f64> {
        self.one_or_list(stem, quantity, domain, |given| {
            (given == 0).then(|| "a list of numbers, not empty".into())
        })
    }

    /// One number `stem` (SI), or a list of them; `refuses` says of a length that is not allowed what
    /// is.
    fn one_or_list(
        &mut self,
        stem: &str,
        quantity: Quantity,
        domain: Domain,
        refuses: impl FnOnce(usize) -> Option<String>,
    ) -> Vec<f64> {
        let ways = [(stem, quantity, domain)];
        let Some((key, _, unit, node)) = self.spelled(&ways) else {
            self.missing(&spellings(&ways).0, "");
            return Vec::new();
        };
        let Value::Array(items) = &node.value else {
            let name = self.dotted(&key);
            return vec![self.si(stem, name, node, (unit, quantity, domain))];
        };
        if let Some(allowed) = refuses(items.len()) {
            self.refuse(self.dotted(&key), node, allowed);
            return Vec::new();
        }
        let items = items.clone();
        self.items((stem, &key), items, (unit, quantity, domain))
    }

    /// So many finite numbers `stem` (SI), if given.
    pub fn array<const N: usize>(&mut self, stem: &str, quantity: Quantity) -> Option<[f64; N]> {
        let (key, _, unit, node) = self.spelled(&[(stem, quantity, Domain::FINITE)])?;
        match &node.value {
            Value::Array(items) if items.len() == N => {
                let items = items.clone();
                let numbers = self.items((stem, &key), items, (unit, quantity, Domain::FINITE));
                numbers.try_into().ok()
            }
            _ => {
                let count = if N == 2 { "two" } else { "three" };
                self.refuse(
                    self.dotted(&key),
                    node,
                    format!("a list of {count} numbers"),
                );
                None
            }
        }
    }

    /// A list of names `key`, not empty and none twice.
    pub fn names(&mut self, key: &str) -> Vec<String> {
        const ALLOWED: &str = "a list of names in quotes, none empty and none twice";
        let read = |value: &Value| {
            let Value::Array(items) = value else {
                return None;
            };
            let mut names: Vec<String> = Vec::new();
            for item in items {
                match &item.value {
                    Value::Text(name) if !name.is_empty() && !names.contains(name) => {
                        names.push(name.clone());
                    }
                    _ => return None,
                }
            }
            Some(names).filter(|names| !names.is_empty())
        };
        self.value(key, ALLOWED, read).unwrap_or_default()
    }

    /// Two numbers `stem` (SI), the lower first, if given.
    pub fn span(&mut self, stem: &str, quantity: Quantity, domain: Domain) -> Option<(f64, f64)> {
        let (key, _, unit, node) = self.spelled(&[(stem, quantity, domain)])?;
        let allowed = "a list of two numbers, the lower first";
        match &node.value {
            Value::Array(items) if items.len() == 2 => {
                let numbers = self.items((stem, &key), items.clone(), (unit, quantity, domain));
                if numbers[0] >= numbers[1] {
                    self.refuse(self.dotted(&key), node, allowed.into());
                }
                Some((numbers[0], numbers[1]))
            }
            Value::Array(items) => {
                let allowed = format!("{allowed}; this list has {}", items.len());
                self.refuse(self.dotted(&key), node, allowed);
                None
            }
            _ => {
                self.refuse(self.dotted(&key), node, allowed.into());
                None
            }
        }
    }

    /// Every key that is left, each a list of a value and its standard deviation, which is above 0; of
    /// a table among them, its keys after its own and a dot. The unit is the name's.
    pub fn known(&mut self) -> Vec<(String, [f64; 2])> {
        const ALLOWED: &str =
            "a list of two numbers: the value and its standard deviation, above 0";
        let keys: Vec<String> = self.entries.keys().cloned().collect();
        let mut all = Vec::new();
        for key in keys {
            if self.is_table(&key) {
                let inner = self.optional_table(&key, |mut table| {
                    let known = table.known();
                    table.finish(known)
                });
                let dotted = |(name, pair): (String, _)| (format!("{key}.{name}"), pair);
                all.extend(inner.into_iter().flatten().map(dotted));
            } else if let Some(pair) = self.value(&key, ALLOWED, pair) {
                all.push((key, pair));
            }
        }
        all
    }

    /// Every key that is left, each a text of which `read` makes something; what it must be is `allowed`.
    pub fn texts<T>(
        &mut self,
        allowed: &str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Vec<(String, T)> {
        let keys: Vec<String> = self.entries.keys().cloned().collect();
        let text = |key: String| Some((key.clone(), self.text_as(&key, allowed, &read)?));
        keys.into_iter().filter_map(text).collect()
    }

    /// The numbers (SI) of the list `key`; messages count its items from 1.
    fn items(
        &mut self,
        (stem, key): (&str, &str),
        items: Vec<Node>,
        meaning: (Unit, Quantity, Domain),
    ) -> Vec<f64> {
        let name = self.dotted(key);
        let item = |(i, item)| self.si(stem, format!("{name} item {}", i + 1), item, meaning);
        items.into_iter().enumerate().map(item).collect()
    }

    /// What `read` makes of the number `stem`, as it is written and in its unit, if given.
    pub fn literal<T>(
        &mut self,
        stem: &str,
        quantity: Quantity,
        allowed: &str,
        read: impl FnOnce(&str, Unit) -> Option<T>,
    ) -> Option<T> {
        let (key, _, unit, node) = self.spelled(&[(stem, quantity, Domain::FINITE)])?;
        let value = match &node.value {
            Value::Number(literal) => read(literal, unit),
            _ => None,
        };
        if value.is_none() {
            self.refuse(self.dotted(&key), node, allowed.into());
        }
        value
    }

    /// The number of `node` in SI, which must be in its domain; messages call it `name`.
    fn si(
        &mut self,
        stem: &str,
        name: String,
        node: Node,
        (unit, quantity, domain): (Unit, Quantity, Domain),
    ) -> f64 {
        let number = match &node.value {
            Value::Number(literal) => unit.si(literal),
            _ => f64::NAN,
        };
        if domain.contains(number) {
            self.numbers.push(Number {
                stem: stem.into(),
                name,
                source: node.source,
                value: number,
                place: node.place,
            });
        } else {
            self.refuse(name, node, domain.describe(quantity, unit));
        }
        number
    }

    /// The key in which one of `ways` is given, which way that is, its unit and its value.
    fn spelled(&mut self, ways: &[Way]) -> Option<(String, usize, Unit, Node)> {
        let (mut keys, meanings) = spellings(ways);
        let spelling = self.given(&keys)?;
        let node = self.entries.remove(&keys[spelling])?;
        let (way, unit) = meanings[spelling];
        Some((keys.swap_remove(spelling), way, unit, node))
    }

    /// What `read` makes of the value of `key`; a value of which it makes nothing is not what is
    /// `allowed`.
    pub(crate) fn value<T>(
        &mut self,
        key: &str,
        allowed: &str,
        read: impl FnOnce(&Value) -> Option<T>,
    ) -> Option<T> {
        let Some(node) = self.take(key) else {
            self.missing(&[key], allowed);
            return None;
        };
        let value = read(&node.value);
        if value.is_none() {
            self.refuse(self.dotted(key), node, allowed.into());
        }
        value
    }

    /// Its keys that were not asked for yet.
    pub fn keys(&self) -> Vec<String> {
        self.entries.keys().cloned().collect()
    }

    /// The text `key`.
    pub fn text(&mut self, key: &str) -> String {
        let read = |value: &Value| match value {
            Value::Text(text) if !text.is_empty() => Some(text.clone()),
            _ => None,
        };
        self.value(key, "text in quotes, not empty", read)
            .unwrap_or_default()
    }

    /// What `read` makes of the text `key`; none after a problem, too.
    pub fn text_as<T>(
        &mut self,
        key: &str,
        allowed: &str,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Option<T> {
        self.value(key, allowed, |value| match value {
            Value::Text(text) => read(text),
            _ => None,
        })
    }

    /// What the text `key` stands for, if it is one of `words`; anything else stays to be read.
    pub fn word<T: Copy>(&mut self, key: &str, words: &[(&str, T)]) -> Option<T> {
        let word = match &self.entries.get(key)?.value {
            Value::Text(text) => words.iter().find(|(word, _)| word == text)?.1,
            _ => return None,
        };
        self.take(key).map(|_| word)
    }

    /// Refuses `key`: it must be `allowed`, such as left out.
    pub fn refuse_key(&mut self, key: &str, allowed: &str) {
        if let Some(node) = self.entries.remove(key) {
            self.refuse(self.dotted(key), node, allowed.into());
        }
    }

    /// The whole number `key`, ≥ 1.
    pub fn count(&mut self, key: &str) -> u32 {
        let read = |value: &Value| match value {
            Value::Number(literal) => literal.parse().ok().filter(|&count| count >= 1),
            _ => None,
        };
        self.value(key, "a whole number ≥ 1", read)
            .unwrap_or_default()
    }

    /// The whole number `key` from 1 to `most`, if given.
    pub fn count_to(&mut self, key: &str, most: usize) -> Option<usize> {
        let node = self.take(key)?;
        let count = match &node.value {
            Value::Number(literal) => literal
                .parse()
                .ok()
                .filter(|count| (1..=most).contains(count)),
            _ => None,
        };
        if count.is_none() {
            self.refuse(
                self.dotted(key),
                node,
                format!("a whole number from 1 to {most}"),
            );
        }
        count
    }

    /// The tables of the list `[[key]]`, at most `most`; messages count them from 1.
    pub fn tables(&mut self, key: &str, most: usize) -> Vec<Section> {
        let Some(node) = self.take(key) else {
            return Vec::new();
        };
        let allowed = format!("a list of tables, in TOML [[{key}]]");
        let Value::Array(items) = node.value else {
            self.refuse(self.dotted(key), node, allowed);
            return Vec::new();
        };
        let (given, name) = (items.len(), self.dotted(key));
        if given > most {
            let allowed = if most == 1 {
                "one table".into()
            } else {
                format!("at most {most} tables")
            };
            self.problem(RobotError::NotAllowed {
                place: node.place,
                key: format!("[[{name}]]"),
                value: format!("{given} tables"),
                allowed,
            });
        }
        let section = |(i, item)| Section::new(format!("{name} {}", i + 1), item);
        let sections: Result<_, _> = items.into_iter().enumerate().map(section).collect();
        sections
            .map_err(|error| self.problem(error))
            .unwrap_or_default()
    }

    /// What the text `key` stands for among `choices`, which `allowed` lists.
    pub fn choice<T: Copy>(&mut self, key: &str, choices: &[(&str, T)], allowed: &str) -> T {
        let read = |value: &Value| match value {
            Value::Text(text) => choices
                .iter()
                .find(|(name, _)| name == text)
                .map(|&(_, choice)| choice),
            _ => None,
        };
        self.value(key, allowed, read).unwrap_or(choices[0].1)
    }

    /// Whether `key` is given.
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Whether `key` is given, and as a table.
    pub fn is_table(&self, key: &str) -> bool {
        matches!(
            self.entries.get(key),
            Some(Node {
                value: Value::Table(_),
                ..
            })
        )
    }

    /// The table `key`, which must be there; an empty one stands in.
    pub fn table(&mut self, key: &str) -> Section {
        let path = self.dotted(key);
        let section = self.take(key).map(|node| Section::new(path.clone(), node));
        match section {
            Some(Ok(section)) => return section,
            Some(Err(error)) => self.problem(error),
            None => self.missing(&[key], ""),
        }
        Section {
            path,
            place: self.place.clone(),
            entries: Table::new(),
            known: Vec::new(),
            numbers: Vec::new(),
            problem: None,
        }
    }

    /// The table `key` through `read`, if given; not read after a problem, on which `read` might
    /// rest.
    pub fn optional_table<T>(
        &mut self,
        key: &str,
        read: impl FnOnce(Section) -> Result<T, RobotError>,
    ) -> Option<T> {
        let (path, node) = (self.dotted(key), self.take(key)?);
        self.attempt(|| Section::new(path, node).and_then(read))
    }

    /// What `read` gives, unless there was a problem before, on which it might rest.
    pub fn attempt<T>(&mut self, read: impl FnOnce() -> Result<T, RobotError>) -> Option<T> {
        if self.problem.is_some() {
            return None;
        }
        read().map_err(|error| self.problem(error)).ok()
    }

    /// Which of `keys`, spellings of one thing, is given. An override drops what the file or an
    /// earlier override spells otherwise.
    pub fn given(&mut self, keys: &[impl AsRef<str>]) -> Option<usize> {
        let mut given: Vec<(usize, Node)> = Vec::new();
        self.known
            .push(keys.iter().map(|key| key.as_ref().to_owned()).collect());
        for (spelling, key) in keys.iter().enumerate() {
            let node = self.entries.remove(key.as_ref());
            given.extend(node.map(|node| (spelling, node)));
        }
        given.sort_by(|(_, a), (_, b)| a.place.cmp(&b.place));
        let (newest, node) = given.pop()?;
        if let Some((other, _)) = given
            .iter()
            .rfind(|(_, other)| other.place.same_source(&node.place))
        {
            let (key, other) = (
                self.dotted(keys[newest].as_ref()),
                self.dotted(keys[*other].as_ref()),
            );
            self.problem(RobotError::GivenTwice {
                place: node.place.clone(),
                key,
                other,
            });
        }
        self.entries.insert(keys[newest].as_ref().into(), node);
        Some(newest)
    }

    /// Notes that none of `keys`, spellings of one thing, is given; what it may be is `allowed`.
    pub fn missing(&mut self, keys: &[impl AsRef<str>], allowed: &str) {
        let keys = keys.iter().map(|key| self.dotted(key.as_ref())).collect();
        self.problem(RobotError::MissingKey {
            place: self.place.clone(),
            keys,
            allowed: allowed.into(),
        });
    }

    /// Whether the number `stem` is given, in any of its units.
    pub(crate) fn gives(&self, stem: &str, quantity: Quantity) -> bool {
        let (keys, _) = spellings(&[(stem, quantity, Domain::FINITE)]);
        keys.iter().any(|key| self.entries.contains_key(key))
    }

    /// An empty table `key` beside this one: each of its keys is missing.
    pub(crate) fn beside(&self, key: &str) -> Section {
        Section {
            path: key.into(),
            place: self.place.clone(),
            entries: Table::new(),
            known: Vec::new(),
            numbers: Vec::new(),
            problem: None,
        }
    }

    /// What `read` makes of the value of `key`, if given; its error is what would be allowed.
    pub(crate) fn read_as<T>(
        &mut self,
        key: &str,
        read: impl FnOnce(&Value) -> Result<T, String>,
    ) -> Option<T> {
        let node = self.take(key)?;
        match read(&node.value) {
            Ok(value) => Some(value),
            Err(allowed) => {
                self.refuse(self.dotted(key), node, allowed);
                None
            }
        }
    }

    fn take(&mut self, key: &str) -> Option<Node> {
        self.known.push(vec![key.into()]);
        self.entries.remove(key)
    }

    fn dotted(&self, key: &str) -> String {
        join(&self.path, &[key])
    }

    fn refuse(
        &mut self,
        key: String,
        Node {
            place,
            source: value,
            ..
        }: Node,
        allowed: String,
    ) {
        self.problem(RobotError::NotAllowed {
            place,
            key,
            value,
            allowed,
        });
    }

    fn problem(&mut self, problem: RobotError) {
        self.problem.get_or_insert(problem);
    }
}

/// A way to give a number: the key without its unit, what it measures, and what is allowed.
pub type Way<'a> = (&'a str, Quantity, Domain);

/// The keys that say one of `ways` in one of its units, and what each means.
fn spellings(ways: &[Way]) -> (Vec<String>, Vec<(usize, Unit)>) {
    let keys = |(way, (stem, quantity, _)): (usize, &Way)| {
        let units = quantity.units.iter();
        let spelled = |&(suffix, unit)| (format!("{stem}{suffix}"), (way, unit));
        units.map(spelled).collect::<Vec<_>>()
    };
    ways.iter().enumerate().flat_map(keys).unzip()
}

/// A value and its standard deviation.
fn pair(value: &Value) -> Option<[f64; 2]> {
    let Value::Array(items) = value else {
        return None;
    };
    let number = |item: &Node| match &item.value {
        Value::Number(literal) => literal.parse().ok().filter(|x: &f64| x.is_finite()),
        _ => None,
    };
    let numbers: Option<Vec<f64>> = items.iter().map(number).collect();
    match numbers?[..] {
        [value, error] if error > 0.0 => Some([value, error]),
        _ => None,
    }
}

/// Whether one is likely the other, misspelt: at most a third of its characters differ, or two letters are
/// exchanged.
fn is_near(a: &str, b: &str) -> bool {
    let length = |text: &str| text.chars().take(MOST_EDITS).count();
    let (edits, length) = (edits(a, b), length(a).max(length(b)));
    3 * edits <= length || (edits <= 2 && edits < length)
}

/// Characters of a text that are compared.
const MOST_EDITS: usize = 64;

/// Characters to insert, delete or replace to get from `a` to `b` (Levenshtein); of a long text
/// only the beginning counts.
pub fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(MOST_EDITS).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().take(MOST_EDITS).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_count_single_characters() {
        let check = |a: &str, b: &str, count: usize| {
            assert_eq!(edits(a, b), count, "{a} {b}");
            assert_eq!(edits(b, a), count, "{b} {a}");
        };
        check("", "", 0);
        check("", "abc", 3);
        check("bore_mm", "bore_mm", 0);
        check("bore_mm", "boer_mm", 2);
        check("bore_mm", "bore_m", 1);
        check("kitten", "sitting", 3);
    }
}
