//! The crate from outside: files, built-in robots, properties.

mod bad_input;
mod built_in;
mod keys;
mod properties;
mod space;
mod spellings;
