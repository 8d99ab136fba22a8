//! Shares of drawn robots.

use saltus::running::Share;
use serde_json::{Value, json};

use super::number::digits;

/// A share as JSON has it.
pub(crate) fn share(share: &Share) -> Value {
    let known = (share.of > 0).then(|| share.value());
    json!({ "count": share.count, "of": share.of, "share": known, "interval_95": share.interval() })
}

/// A share in words.
pub(crate) fn in_words(share: &Share) -> String {
    let percent = |x: f64| digits(100.0 * x, 3);
    let [low, high] = share.interval();
    format!(
        "{} of {}, {} % (95 %: {} to {} %)",
        share.count,
        share.of,
        if share.of == 0 {
            "–".into()
        } else {
            percent(share.value())
        },
        percent(low),
        percent(high)
    )
}
