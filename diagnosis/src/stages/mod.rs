//! The stages of a diagnosis, in the order in which they are at work.

pub(crate) mod screen;
pub(crate) mod small;

pub(crate) mod candidates;

pub(crate) mod pairs;

pub(crate) mod add;

pub(crate) mod exchange;

pub(crate) mod prune;

pub(crate) mod unknown;

pub(crate) mod rivals;
