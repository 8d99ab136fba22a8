//! Definitions of messages as they stand in files (`ros2msg`), read.
//!
//! Source: ROS 2 design, Interface definition using .msg files, and MCAP's registry of schema
//! encodings: the types that a type uses follow it, each after a line of `=` and a line `MSG:`.

use std::collections::BTreeMap;

use crate::Error;

/// Deepest nesting of types.
const DEEPEST: usize = 32;
/// Most types of a definition.
const MOST: usize = 1_000;

/// A type of messages with the types that it uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// Package and name.
    pub(crate) name: String,
    /// Layouts; the first is that of the message.
    pub(crate) layouts: Vec<Layout>,
}

/// The fields of a type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) fields: Vec<Slot>,
}

/// A field of a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) count: Count,
}

/// What a field holds, or each of its elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Number(Number),
    Text,
    /// Index of a layout.
    Nested(usize),
}

/// A primitive type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// How many elements a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Count {
    One,
    Fixed(usize),
    Sequence,
}

impl Number {
    /// Bytes.
    pub(crate) fn size(self) -> usize {
        match self {
            Number::Bool | Number::I8 | Number::U8 => 1,
            Number::I16 | Number::U16 => 2,
            Number::I32 | Number::U32 | Number::F32 => 4,
            Number::I64 | Number::U64 | Number::F64 => 8,
        }
    }

    fn named(word: &str) -> Option<Number> {
        Some(match word {
            "bool" => Number::Bool,
            "int8" => Number::I8,
            "uint8" | "byte" | "char" => Number::U8,
            "int16" => Number::I16,
            "uint16" => Number::U16,
            "int32" => Number::I32,
            "uint32" => Number::U32,
            "int64" => Number::I64,
            "uint64" => Number::U64,
            "float32" => Number::F32,
            "float64" => Number::F64,
            _ => return None,
        })
    }
}

/// A type as it stands in the text.
struct Section<'t> {
    name: String,
    lines: Vec<(usize, &'t str)>,
}

impl Schema {
    /// The type `name` that `text` defines.
    ///
    /// # Errors
    /// [`Error::Definition`] for a text that defines none.
    pub fn parse(name: &str, text: &str) -> Result<Schema, Error> {
        let sections = sections(name, text)?;
        let mut schema = Schema {
            name: name.into(),
            layouts: Vec::new(),
        };
        for section in &sections {
            let fields = section.lines.iter().filter_map(|(line, text)| {
                let read = slot(text, &sections, section);
                read.map_err(|reason| refused(&section.name, *line, reason))
                    .transpose()
            });
            let fields = fields.collect::<Result<Vec<Slot>, Error>>()?;
            schema.layouts.push(Layout {
                fields: never_empty(fields),
            });
        }
        schema.depth(0, 0, &mut BTreeMap::new())?;
        Ok(schema)
    }

    /// Names of the fields of a message that are one number each.
    pub fn numbers(&self) -> Vec<&str> {
        let fields = self.layouts[0].fields.iter();
        let is_number = |f: &&Slot| matches!(f.kind, Kind::Number(_)) && f.count == Count::One;
        fields.filter(is_number).map(|f| f.name.as_str()).collect()
    }

    /// Refuses types that hold themselves.
    fn depth(
        &self,
        layout: usize,
        above: usize,
        known: &mut BTreeMap<usize, usize>,
    ) -> Result<usize, Error> {
        if above > DEEPEST {
            let reason = format!("types are nested more than {DEEPEST} times, or hold themselves");
            return Err(refused(&self.name, 1, reason));
        }
        if let Some(depth) = known
            .get(&layout)
            .filter(|depth| above + **depth <= DEEPEST)
        {
            return Ok(*depth);
        }
        let mut deepest = 0;
        for field in &self.layouts[layout].fields {
            if let Kind::Nested(inner) = field.kind {
                deepest = deepest.max(1 + self.depth(inner, above + 1, known)?);
            }
        }
        known.insert(layout, deepest);
        Ok(deepest)
    }
}

/// CDR has no type without bytes: an empty one holds one that means nothing.
fn never_empty(mut fields: Vec<Slot>) -> Vec<Slot> {
    if fields.is_empty() {
        fields.push(Slot {
            name: "structure_needs_at_least_one_member".into(),
            kind: Kind::Number(Number::U8),
            count: Count::One,
        });
    }
    fields
}

fn refused(name: &str, line: usize, reason: impl Into<String>) -> Error {
    Error::Definition {
        name: name.into(),
        line,
        reason: reason.into(),
    }
}

/// A type's name without the word between package and name.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

fn sections<'t>(name: &str, text: &'t str) -> Result<Vec<Section<'t>>, Error> {
    let mut sections = vec![Section {
        name: plain(name),
        lines: Vec::new(),
    }];
    let mut lines = (1..).zip(text.lines());
    while let Some((number, line)) = lines.next() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.len() >= 3 && line.bytes().all(|c| c == b'=') {
            let head = lines.next().map_or("", |(_, line)| line.trim());
            let Some(next) = head.strip_prefix("MSG:") else {
                return Err(refused(
                    name,
                    number + 1,
                    "must be MSG: and the name of a type",
                ));
            };
            sections.push(Section {
                name: plain(next.trim()),
                lines: Vec::new(),
            });
            if sections.len() > MOST {
                let reason = format!("more than {MOST} types");
                return Err(refused(name, number, reason));
            }
        } else if let Some(section) = sections.last_mut().filter(|_| !line.is_empty()) {
            section.lines.push((number, line));
        }
    }
    Ok(sections)
}

/// The field that a line defines; none: a constant.
fn slot(
    line: &str,
    sections: &[Section<'_>],
    inside: &Section<'_>,
) -> Result<Option<Slot>, String> {
    let (kind, rest) = line
        .split_once(char::is_whitespace)
        .ok_or("must be a type and a name")?;
    let rest = rest.trim_start();
    let end = rest.find([' ', '\t', '=']).unwrap_or(rest.len());
    let (name, after) = (&rest[..end], rest[end..].trim_start());
    if after.starts_with('=') {
        return Ok(None);
    }
    let (kind, count) = counted(kind)?;
    // A bounded string has its bound behind.
    let word = kind.split("<=").next().unwrap_or(kind);
    let kind = match (Number::named(word), word) {
        (Some(number), _) => Kind::Number(number),
        (None, "string") => Kind::Text,
        (None, "wstring") => return Err("wstring is not read here".into()),
        _ => Kind::Nested(
            place(word, sections, inside)
                .ok_or_else(|| format!("the type {word} is not defined below"))?,
        ),
    };
    Ok(Some(Slot {
        name: name.into(),
        kind,
        count,
    }))
}

/// The type of an element and how many there are.
fn counted(kind: &str) -> Result<(&str, Count), String> {
    let Some(open) = kind.find('[') else {
        return Ok((kind, Count::One));
    };
    let inside = kind[open + 1..].strip_suffix(']');
    let inside = inside.ok_or("a [ has no ] at the end of the type")?;
    let count = match inside {
        "" => Count::Sequence,
        bounded if bounded.starts_with("<=") => Count::Sequence,
        number => match number.parse::<usize>() {
            Ok(count) if count > 0 => Count::Fixed(count),
            _ => return Err(format!("[{number}]: must be a whole number above 0")),
        },
    };
    Ok((&kind[..open], count))
}

/// Which section defines the type `word`, used by the type `inside`.
fn place(word: &str, sections: &[Section<'_>], inside: &Section<'_>) -> Option<usize> {
    let package = inside
        .name
        .rsplit_once('/')
        .map_or("", |(package, _)| package);
    let full = match plain(word) {
        name if name == "Header" => "std_msgs/Header".into(),
        name if name.contains('/') => name,
        name => format!("{package}/{name}"),
    };
    sections.iter().position(|section| section.name == full)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Definition;

    #[test]
    fn standard_types_are_read() {
        for definition in Definition::STANDARD {
            let schema = Schema::parse(&definition.name, &definition.text).expect("a definition");
            assert!(!schema.layouts[0].fields.is_empty(), "{}", definition.name);
        }
    }

    #[test]
    fn lines_of_all_kinds_are_read() {
        let text = "# a comment\nuint8 BIG=200 # one\nstring NAME = 'a b'\nstring<=9 s 'default'\n\
            float32[3] a [1, 2, 3]\nint16[<=4] b\nOther c\nbyte d 3\n===\nMSG: p/Other\n";
        let schema = Schema::parse("p/msg/T", text).expect("a definition");
        let fields: Vec<(&str, Count)> = schema.layouts[0]
            .fields
            .iter()
            .map(|field| (field.name.as_str(), field.count))
            .collect();
        let expected = [
            ("s", Count::One),
            ("a", Count::Fixed(3)),
            ("b", Count::Sequence),
            ("c", Count::One),
            ("d", Count::One),
        ];
        assert_eq!(fields, expected);
        assert_eq!(schema.layouts[1].fields.len(), 1);
    }

    #[test]
    fn bad_definitions_are_refused_by_line() {
        let check = |text: &str, said: &str| {
            let error = Schema::parse("p/msg/T", text).expect_err(text).to_string();
            assert!(error.contains(said), "{error}");
        };
        check("float64", "line 1: must be a type and a name");
        check("float64 x\nNone y", "line 2: the type None is not defined");
        check("wstring s", "wstring is not read here");
        check("float64[0] x", "whole number above 0");
        check("float64[x y", "a [ has no ]");
        check("p/T t", "hold themselves");
        check(
            "A a\n===\nMSG: p/A\nB b\n===\nMSG: p/B\nA a\n",
            "hold themselves",
        );
        check("===\nfloat64 x", "must be MSG:");
    }
}
