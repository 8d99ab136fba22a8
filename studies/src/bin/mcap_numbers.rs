//! Numbers of an MCAP file as CSV: `mcap_numbers FILE PATH...`, with paths such as
//! `/imu.angular_velocity.y`. A row for each message of their topics: time of the log (ns), topic, and
//! the numbers that stand in it. Without arguments, those of a file of the tests.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::error::Error;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};

use saltus_telemetry::{Event, Field, Path, Selection, read};

fn main() -> Result<(), Box<dyn Error>> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    if words.is_empty() {
        let own = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../telemetry/tests/files/zstd.mcap"
        );
        let paths = ["/imu.angular_velocity.y", "/joint_states.position[leg1]"];
        words.push(own.into());
        words.extend(paths.map(str::to_owned));
    }
    let file = BufReader::new(File::open(words.remove(0))?);
    let paths: Vec<Path> = words
        .iter()
        .map(|text| text.parse())
        .collect::<Result<_, _>>()?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    writeln!(out, "log_time_ns,topic,{}", words.join(","))?;
    let mut selections: BTreeMap<u16, (Selection, Vec<usize>)> = BTreeMap::new();
    let ended = read(file, &mut |event| {
        let Event::Message {
            channel,
            log_time,
            data,
        } = event
        else {
            return Ok(());
        };
        let here: Vec<usize> = (0..paths.len())
            .filter(|k| paths[*k].topic == channel.topic)
            .collect();
        if here.is_empty() {
            return Ok(());
        }
        let (selection, here) = match selections.entry(channel.id) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let fields: Vec<&[Field]> = here.iter().map(|k| &paths[*k].fields[..]).collect();
                place.insert((channel.layout()?.select(&fields)?, here))
            }
        };
        let mut found = vec![f64::NAN; here.len()];
        selection.find(data, &mut found)?;
        let mut cells = vec![String::new(); paths.len()];
        for (k, x) in here.iter().zip(&found) {
            cells[*k] = format!("{x:?}");
        }
        writeln!(out, "{log_time},{},{}", channel.topic, cells.join(","))?;
        Ok(())
    });
    out.flush()?;
    if let Err(error) = ended {
        return Err(format!("{}: {error}", words.first().map_or("the file", |word| word)).into());
    }
    Ok(())
}
