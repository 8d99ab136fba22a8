//! The laboratory: what it hides can be seen, and follows from the seed.

use std::time::Instant;

use saltus_diagnosis::Sort;
use saltus_tests::lab::{SORTS, Size, causes_of, kinds_of, make, outside};

#[test]
#[ignore = "survey"]
fn survey() {
    let only = std::env::var("KIND").unwrap_or_default();
    for kind in SORTS {
        if !only.is_empty() && !only.contains(&format!("{kind:?}")) {
            continue;
        }
        for &id in causes_of(kind).iter().chain(outside(kind)) {
            let id_only = std::env::var("ID").unwrap_or_default();
            if !id_only.is_empty() && !id_only.contains(id) {
                continue;
            }
            for seed in 0..2 {
                let start = Instant::now();
                let both = [Size::Clear, Size::Subtle].map(|size| make(kind, &[(id, size)], seed));
                let time = start.elapsed().as_secs_f64() / 2.0;
                let [a, b] = both.each_ref().map(|case| &case.truth[0]);
                let mark = if a.sigmas < 5.0 || b.sigmas > 2.5 || b.sigmas < 1.7 { "***" } else { "" };
                println!(
                    "{kind:?} {id} {seed}: {:.1} {:.2} runs {} time {time:.2} {:?} {:?} {mark}",
                    a.sigmas, b.sigmas, both[0].experiment.runs.len(), a.parameters, b.parameters
                );
            }
        }
    }
}

#[test]
#[ignore = "survey"]
fn effort() {
    for kind in [Sort::Hop, Sort::Jump, Sort::Outcomes] {
        let start = Instant::now();
        let case = make(kind, &[], 1);
        println!("{kind:?} {:?} {} runs {} rows", start.elapsed(), case.experiment.runs.len(), case.experiment.runs[0].time.len());
    }
}
