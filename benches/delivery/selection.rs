//! The selection of cells from the command line.

use std::fmt;

/// Whether both ends can send at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Duplex {
    Full,
    Half,
}

impl Duplex {
    /// A channel specification with this kind of radio.
    pub fn over(self, channel: &str) -> String {
        match self {
            Self::Full => channel.to_owned(),
            Self::Half if channel.is_empty() => "half-duplex".to_owned(),
            Self::Half => format!("{channel},half-duplex"),
        }
    }
}

impl fmt::Display for Duplex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "full duplex",
            Self::Half => "half duplex",
        })
    }
}

/// A part of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    Lists,
    Commands,
    Stop,
    Cold,
}

/// Errors in bursts of 50 bits on average, in which every other bit flips. A burst damages five bytes; on average
/// 25,000 bits, or ten seconds, lie between two bursts.
pub const BURST: &str = "ber=1e-3,burst=50";

/// The selected cells.
#[derive(Debug)]
pub struct Selection {
    pub sections: Vec<Section>,
    pub duplexes: Vec<Duplex>,
    pub counts: Vec<usize>,
    /// Channel specifications without the kind of radio.
    pub channels: Vec<String>,
    pub mavlink: bool,
    pub seeds: u64,
}

impl Selection {
    /// Reads the arguments after `--`.
    pub fn from_words(words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut selection = Self {
            sections: Vec::new(),
            duplexes: Vec::new(),
            counts: Vec::new(),
            channels: Vec::new(),
            mavlink: false,
            seeds: 200,
        };
        let mut words = words;
        while let Some(word) = words.next() {
            match word.as_str() {
                // Cargo passes this to every bench.
                "--bench" => {}
                "full" => selection.duplexes.push(Duplex::Full),
                "half" => selection.duplexes.push(Duplex::Half),
                "lists" => selection.sections.push(Section::Lists),
                "commands" => selection.sections.push(Section::Commands),
                "stop" => selection.sections.push(Section::Stop),
                "cold" => selection.sections.push(Section::Cold),
                "mavlink" => selection.mavlink = true,
                "burst" => selection.channels.push(BURST.to_owned()),
                "0" => selection.channels.push(String::new()),
                "--seeds" => {
                    let seeds = words.next().and_then(|seeds| seeds.parse().ok());
                    selection.seeds = seeds.ok_or("--seeds takes a number, like --seeds 50")?;
                }
                _ => selection.number(&word)?,
            }
        }
        let all = selection.sections.is_empty() && selection.has_no_filter();
        if all {
            selection.mavlink = true;
            selection.sections = vec![
                Section::Lists,
                Section::Commands,
                Section::Stop,
                Section::Cold,
            ];
        } else if selection.sections.is_empty() {
            selection.sections.push(Section::Lists);
        }
        if selection.duplexes.is_empty() {
            selection.duplexes = vec![Duplex::Full, Duplex::Half];
        }
        if selection.counts.is_empty() {
            selection.counts = vec![10, 100, 300];
        }
        if selection.channels.is_empty() {
            selection.channels = ["", "ber=1e-4", "ber=1e-3", "ber=3e-3", BURST]
                .map(str::to_owned)
                .into();
        }
        Ok(selection)
    }

    fn has_no_filter(&self) -> bool {
        self.duplexes.is_empty() && self.counts.is_empty() && self.channels.is_empty()
    }

    fn number(&mut self, word: &str) -> Result<(), String> {
        if let Ok(count @ 1..=300) = word.parse() {
            self.counts.push(count);
        } else if word
            .parse::<f64>()
            .is_ok_and(|ber| (0.0..0.25).contains(&ber))
        {
            self.channels.push(format!("ber={word}"));
        } else {
            return Err(format!(
                "`{word}`: write full, half, 1 to 300 waypoints, a bit error rate like 3e-3, burst, mavlink, \
                 lists, commands, stop, cold, --seeds N"
            ));
        }
        Ok(())
    }

    /// Channel names for the header of the table.
    pub fn channel_names(&self) -> Vec<&str> {
        self.channels
            .iter()
            .map(|channel| match channel.as_str() {
                "" => "0",
                BURST => "1e-3 in bursts of 50 bits",
                other => other.trim_start_matches("ber="),
            })
            .collect()
    }
}
