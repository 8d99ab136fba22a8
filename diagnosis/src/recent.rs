//! Answers to what searches ask again and again.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// Questions and their answers, what was asked last at the end. A copy begins without any.
#[derive(Debug)]
pub(crate) struct Recent<Q, A>(Mutex<VecDeque<(Q, A)>>);

impl<Q, A> Default for Recent<Q, A> {
    fn default() -> Recent<Q, A> {
        Recent(Mutex::default())
    }
}

impl<Q, A> Clone for Recent<Q, A> {
    fn clone(&self) -> Recent<Q, A> {
        Recent::default()
    }
}

impl<Q: PartialEq, A: Clone> Recent<Q, A> {
    /// The answer to `question`, by `answer` where it is not known; `most` are kept.
    pub(crate) fn ask(&self, question: Q, most: usize, answer: impl FnOnce(&Q) -> A) -> A {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let again = || {
            let mut all = all();
            // What is asked again is forgotten last.
            let known = all.iter().rposition(|known| known.0 == question)?;
            let known = all.remove(known)?;
            let answer = known.1.clone();
            all.push_back(known);
            Some(answer)
        };
        if let Some(answer) = again() {
            return answer;
        }
        let answer = answer(&question);
        let mut all = all();
        all.push_back((question, answer.clone()));
        while all.len() > most {
            all.pop_front();
        }
        answer
    }
}
