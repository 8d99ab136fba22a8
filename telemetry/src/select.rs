//! Numbers of messages, found by the definition that a file has.

use crate::Error;
use crate::path::{Field, Index};
use crate::schema::{Count, Kind, Layout, Number, Schema, Slot};

/// Numbers to find in messages of one type.
#[derive(Clone, Debug)]
pub struct Selection {
    schema: Schema,
    wanted: Vec<Wanted>,
}

/// What is wanted of a layout.
#[derive(Clone, Debug)]
struct Wanted {
    /// Index of the field.
    field: usize,
    index: Option<Index>,
    then: Then,
}

#[derive(Clone, Debug)]
enum Then {
    /// The number goes to this place.
    Take(usize),
    Into(Box<Wanted>),
}

impl Schema {
    /// The numbers to which `paths` lead, fields within fields.
    ///
    /// # Errors
    /// [`Error::Path`] for a path that leads to no number.
    pub fn select(&self, paths: &[&[Field]]) -> Result<Selection, Error> {
        let wanted = paths
            .iter()
            .enumerate()
            .map(|(place, path)| self.wanted(0, path, place));
        Ok(Selection {
            wanted: wanted.collect::<Result<_, _>>()?,
            schema: self.clone(),
        })
    }

    fn wanted(&self, layout: usize, path: &[Field], place: usize) -> Result<Wanted, Error> {
        let Some((first, rest)) = path.split_first() else {
            let reason = format!("must name a field of {}", self.name);
            return Err(Error::Path {
                path: String::new(),
                reason,
            });
        };
        let refused = |reason: String| Error::Path {
            path: first.to_string(),
            reason,
        };
        let layout = &self.layouts[layout];
        let Some(field) = layout.fields.iter().position(|f| f.name == first.name) else {
            let names: Vec<&str> = layout.fields.iter().map(|f| f.name.as_str()).collect();
            let reason = format!(
                "no field of {}: its fields are {}",
                self.name,
                names.join(", ")
            );
            return Err(refused(reason));
        };
        let slot = &layout.fields[field];
        indexed(layout, field, first).map_err(refused)?;
        let then = match (slot.kind, rest) {
            (Kind::Number(_), []) => Then::Take(place),
            (Kind::Nested(inner), [_, ..]) => {
                Then::Into(Box::new(self.wanted(inner, rest, place)?))
            }
            (Kind::Nested(inner), []) => {
                let names: Vec<&str> = self.layouts[inner]
                    .fields
                    .iter()
                    .map(|f| f.name.as_str())
                    .collect();
                return Err(refused(format!(
                    "is no number: its fields are {}",
                    names.join(", ")
                )));
            }
            (Kind::Text, []) => return Err(refused("is a text and no number".into())),
            (_, [_, ..]) => return Err(refused("has no fields".into())),
        };
        Ok(Wanted {
            field,
            index: first.index.clone(),
            then,
        })
    }
}

/// Refuses an element where there is one alone, and none where there are several.
fn indexed(layout: &Layout, field: usize, asked: &Field) -> Result<(), String> {
    match (layout.fields[field].count, &asked.index) {
        (Count::One, None) => Ok(()),
        (Count::One, Some(_)) => Err("is not a list".into()),
        (_, None) => Err("is a list: say which element, as in [0]".into()),
        (Count::Fixed(count), Some(Index::Number(index))) if *index >= count => {
            Err(format!("has the elements 0 to {}", count - 1))
        }
        (_, Some(Index::Number(_))) => Ok(()),
        (_, Some(Index::Name(_))) => {
            let before = &layout.fields[..field];
            let is_names =
                |f: &Slot| f.name == "name" && f.kind == Kind::Text && f.count != Count::One;
            if before.iter().any(is_names) {
                Ok(())
            } else {
                Err("an element by its name needs a list of texts called name before it".into())
            }
        }
    }
}

impl Selection {
    /// Puts the numbers of a message in their places of `out`; what the message does not have, such
    /// as an element that is not there, is left as it is.
    ///
    /// # Errors
    /// [`Error::Message`] for bytes that do not fit the definition.
    ///
    /// # Panics
    /// If `out` has fewer places than the selection has paths.
    pub fn find(&self, message: &[u8], out: &mut [f64]) -> Result<(), Error> {
        let refused = |reason| Error::Message {
            name: self.schema.name.clone(),
            bytes: message.len(),
            reason,
        };
        let mut walk = Walk {
            schema: &self.schema,
            cursor: Cursor::new(message).map_err(refused)?,
            out,
        };
        let wanted: Vec<&Wanted> = self.wanted.iter().collect();
        walk.layout(0, &wanted).map_err(refused)
    }
}

type Result_<T> = Result<T, &'static str>;

const SHORT: &str = "it ends too early";

struct Walk<'a> {
    schema: &'a Schema,
    cursor: Cursor<'a>,
    out: &'a mut [f64],
}

impl<'a> Walk<'a> {
    fn layout(&mut self, layout: usize, wanted: &[&Wanted]) -> Result_<()> {
        let schema = self.schema;
        let fields = &schema.layouts[layout].fields;
        let by_name = |w: &&Wanted| matches!(w.index, Some(Index::Name(_)));
        let mut names: Option<Vec<&'a [u8]>> = None;
        let needs_names = wanted.iter().any(by_name);
        let last = wanted.iter().map(|w| w.field).max();
        for (k, slot) in fields.iter().enumerate() {
            if needs_names && slot.name == "name" && slot.kind == Kind::Text {
                names = Some(self.texts(slot.count)?);
                continue;
            }
            let here = wanted.iter().filter(|w| w.field == k);
            let mut here = here.copied().peekable();
            if here.peek().is_none() {
                self.skip(slot)?;
                continue;
            }
            let of: Vec<(Option<usize>, &Wanted)> =
                here.map(|w| (element(w, names.as_deref()), w)).collect();
            self.field(slot, &of)?;
            // What follows the last field of a message is of no interest.
            if layout == 0 && last == Some(k) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// A field of which some elements are wanted.
    fn field(&mut self, slot: &Slot, of: &[(Option<usize>, &Wanted)]) -> Result_<()> {
        let count = self.count(slot.count)?;
        let one = Slot {
            count: Count::One,
            name: String::new(),
            kind: slot.kind,
        };
        let mut at = 0;
        let mut indices: Vec<usize> = of
            .iter()
            .filter_map(|(k, _)| *k)
            .filter(|k| *k < count)
            .collect();
        indices.sort_unstable();
        indices.dedup();
        for index in indices {
            self.skip_some(slot.kind, index - at)?;
            at = index + 1;
            let here = || {
                of.iter()
                    .filter(|(k, _)| *k == Some(index))
                    .map(|(_, w)| *w)
            };
            if let Kind::Nested(inner) = one.kind {
                let wanted: Vec<&Wanted> = here()
                    .filter_map(|w| match &w.then {
                        Then::Into(next) => Some(&**next),
                        Then::Take(_) => None,
                    })
                    .collect();
                self.layout(inner, &wanted)?;
            } else if let Kind::Number(number) = one.kind {
                let x = self.cursor.number(number)?;
                for w in here() {
                    if let Then::Take(place) = w.then {
                        self.out[place] = x;
                    }
                }
            }
        }
        self.skip_some(slot.kind, count - at)
    }

    fn count(&mut self, count: Count) -> Result_<usize> {
        match count {
            Count::One => Ok(1),
            Count::Fixed(count) => Ok(count),
            Count::Sequence => self.cursor.length(),
        }
    }

    fn texts(&mut self, count: Count) -> Result_<Vec<&'a [u8]>> {
        let count = self.count(count)?;
        // Each has at least the bytes of its length.
        if count > self.cursor.rest() / 4 {
            return Err(SHORT);
        }
        (0..count).map(|_| self.cursor.text()).collect()
    }

    fn skip(&mut self, slot: &Slot) -> Result_<()> {
        let count = self.count(slot.count)?;
        self.skip_some(slot.kind, count)
    }

    fn skip_some(&mut self, kind: Kind, count: usize) -> Result_<()> {
        match kind {
            Kind::Number(_) if count == 0 => Ok(()),
            Kind::Number(number) => self.cursor.skip(number.size(), count),
            Kind::Text => (0..count).try_for_each(|_| self.cursor.text().map(|_| ())),
            Kind::Nested(inner) => (0..count).try_for_each(|_| self.layout(inner, &[])),
        }
    }
}

/// Which element a number is of; none: of none that is there.
fn element(wanted: &Wanted, names: Option<&[&[u8]]>) -> Option<usize> {
    match &wanted.index {
        None => Some(0),
        Some(Index::Number(index)) => Some(*index),
        Some(Index::Name(name)) => names?.iter().position(|n| *n == name.as_bytes()),
    }
}

/// A place in a message.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
}

impl<'a> Cursor<'a> {
    fn new(message: &'a [u8]) -> Result_<Cursor<'a>> {
        let (head, bytes) = message.split_at_checked(4).ok_or("it has no head")?;
        let big = match head[1] {
            0 => true,
            1 => false,
            _ => return Err("its head does not say plain CDR (0 or 1)"),
        };
        Ok(Cursor { bytes, at: 0, big })
    }

    fn rest(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn skip(&mut self, size: usize, count: usize) -> Result_<()> {
        let start = self.at.next_multiple_of(size);
        let end = size.checked_mul(count).and_then(|n| start.checked_add(n));
        self.at = end.filter(|end| *end <= self.bytes.len()).ok_or(SHORT)?;
        Ok(())
    }

    fn take<const N: usize>(&mut self) -> Result_<[u8; N]> {
        self.skip(N, 1)?;
        let mut bytes: [u8; N] = self.bytes[self.at - N..self.at]
            .try_into()
            .map_err(|_| SHORT)?;
        if self.big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn length(&mut self) -> Result_<usize> {
        let count = u32::from_le_bytes(self.take()?) as usize;
        // Every element has at least a byte.
        if count > self.rest() {
            return Err("a list is longer than the message");
        }
        Ok(count)
    }

    /// The bytes of a text, without the zero at its end.
    fn text(&mut self) -> Result_<&'a [u8]> {
        let length = self.length()?;
        let all = self.bytes;
        let text = &all[self.at..self.at + length];
        self.at += length;
        Ok(text.strip_suffix(&[0]).unwrap_or(text))
    }

    fn number(&mut self, number: Number) -> Result_<f64> {
        Ok(match number {
            Number::Bool => f64::from(u8::from(self.take::<1>()?[0] != 0)),
            Number::U8 => f64::from(self.take::<1>()?[0]),
            Number::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Number::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Number::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Number::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Number::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Number::I64 => i64::from_le_bytes(self.take()?) as f64,
            Number::U64 => u64::from_le_bytes(self.take()?) as f64,
            Number::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Number::F64 => f64::from_le_bytes(self.take()?),
        })
    }
}
