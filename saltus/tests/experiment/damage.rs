//! Folders damaged at random.

use saltus::experiment::read;

use crate::folder::Folder;
use crate::{KINDS, good};

/// Nothing that is done to a folder makes the reader panic, or say more than a line.
#[test]
fn no_damage_makes_it_panic() {
    let data = Folder::new("damaged");
    let mut random = Random(7);
    let mut read_well = 0;
    for case in 0..800 {
        let mut files = good(KINDS[case % 8]).map(|(name, text)| (name, text.into_bytes()));
        for _ in 0..=random.below(3) {
            damage(&mut files[random.below(3)].1, &mut random);
        }
        for (name, bytes) in &files {
            data.write(name, bytes);
        }
        match read(&data.path(""), &|_| ()) {
            Ok(_) => read_well += 1,
            Err(error) => {
                let text = error.to_string();
                assert!(
                    text.starts_with(data.path("").to_str().unwrap()),
                    "{case}: {text}"
                );
                assert!(!text.contains('\n') && text.len() < 500, "{case}: {text}");
            }
        }
    }
    // Damage may be harmless, to a digit say; mostly it is not.
    assert!((1..400).contains(&read_well), "{read_well}");
}

fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    const WORDS: [&[u8]; 12] = [
        b",",
        b"\n",
        b"\"",
        b"-",
        b"e9",
        b"nan",
        b"\xff",
        b"\0",
        b"[[run]]\n",
        b"=",
        b"\r",
        b"999999999999999999999",
    ];
    let place = random.below(bytes.len() + 1);
    let line = |from: usize| {
        bytes[from..]
            .iter()
            .position(|byte| *byte == b'\n')
            .map_or(bytes.len(), |end| from + end)
    };
    let (to, word) = (line(place), WORDS[random.below(12)]);
    match random.below(6) {
        0 => drop(bytes.splice(place..place, word.iter().copied())),
        1 => drop(bytes.drain(place..to)),
        2 => bytes.truncate(place),
        3 => {
            let copy = bytes[place..to].to_vec();
            bytes.splice(place..place, copy);
        }
        _ if place < bytes.len() => bytes[place] ^= 1 << random.below(8),
        _ => bytes.clear(),
    }
}

/// Numbers that look random: a linear congruential generator with Knuth's constants.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % end
    }
}
