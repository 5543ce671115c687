//! Summary of a capture as text.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Info;
use crate::diagnosis;
use crate::event::Moment;
use crate::outages::Outage;
use crate::words::{clock_words, counted, plural};

/// Minimum factor and additional seconds by which the robot's clock shows more time than a capture lasts, if the capture has no pauses.
const PAUSES_FACTOR: f64 = 1.03;
const PAUSES_S: f64 = 2.0;

/// Maximum number of outages that the text lists; JSON contains all.
const OUTAGES_SHOWN: usize = 10;

impl Info {
    /// Writes the run and its origin.
    fn write_origin(&self, output: &mut impl Write) -> io::Result<()> {
        for (what, words) in [
            ("run", &self.name),
            ("VOID", &self.void),
            ("made", &self.start),
            ("link", &self.link),
            ("software", &self.software),
        ] {
            if let Some(words) = words {
                writeln!(output, "{what:<11}{words}")?;
            }
        }
        if let Some(words) = &self.stored {
            writeln!(output, "stored     {words}")?;
        }
        for note in &self.notes {
            writeln!(output, "note       {note}")?;
        }
        for mark in &self.marks {
            let at = clock_words(Moment::try_from_secs_f64(mark.at_s).unwrap_or_default());
            let text = mark
                .text
                .as_ref()
                .map_or(String::new(), |text| format!("  {text}"));
            writeln!(output, "mark       {at}{text}")?;
        }
        Ok(())
    }

    fn write_damaged(&self, output: &mut impl Write) -> io::Result<()> {
        self.damaged.write_row(output)?;
        if let Some(clause) = diagnosis::clause(&self.mistakes) {
            writeln!(output, "mistakes   {clause}; `groundwave check` shows more")?;
        }
        self.other.write_rows(output)
    }

    /// Whether all lines are the robot's own.
    fn is_own(&self) -> bool {
        let own = self.own.as_ref();
        self.lines.total() == 0 && own.is_some_and(|own| own.outweighs(&self.damaged))
    }

    /// Writes the bytes, and Groundwave's lines unless all lines are the robot's own.
    fn write_received(&self, output: &mut impl Write) -> io::Result<()> {
        let all = self.lines.total();
        let is_own = self.is_own();
        write!(output, "bytes      {} received", self.bytes)?;
        if is_own {
            writeln!(output)?;
        } else {
            let noise = self.noise_bytes - self.unfinished_bytes;
            writeln!(output, ", {noise} noise")?;
        }
        if self.unfinished_bytes > 0 {
            writeln!(
                output,
                "end        in the middle of a line, {} of it",
                counted(self.unfinished_bytes, "byte")
            )?;
        }
        if self.missing_bytes > 0 {
            writeln!(output, "missing    {}", counted(self.missing_bytes, "byte"))?;
        }
        if is_own {
            return Ok(());
        }
        let [a, b, c, t, k] = ["A", "B", "C", "T", "K"].map(|letter| self.lines.of(letter));
        let mut rare = match (self.lines.of("P"), self.lines.of("S")) {
            (0, 0) => String::new(),
            (p, s) => format!(", P {p}, S {s}"),
        };
        for letter in ["I", "F", "V"] {
            let count = self.lines.of(letter);
            if count > 0 {
                let _ = write!(rare, ", {letter} {count}");
            }
        }
        writeln!(
            output,
            "lines      {all} intact: {} long (A {a}, B {b}, C {c}, T {t}{rare}), {k} short (K)",
            all - k
        )?;
        writeln!(
            output,
            "loss       {} line{}, {}, {}",
            self.loss.lines(),
            plural(self.loss.lines_lost_max.unwrap_or(self.loss.lines_lost)),
            self.loss.share(),
            counted(self.gaps, "gap")
        )?;
        self.write_damaged(output)
    }

    /// Writes the lines of the robot's own and their fields.
    fn write_own(&self, output: &mut impl Write) -> io::Result<()> {
        let Some(own) = &self.own else {
            return Ok(());
        };
        own.write_row(output)?;
        for field in &own.fields {
            let unit = field
                .unit
                .as_deref()
                .map_or(String::new(), |unit| format!(" {unit}"));
            write!(
                output,
                "field      {}: {}",
                field.name,
                counted(field.values, "value")
            )?;
            match (field.least, field.greatest) {
                (Some(least), Some(greatest)) => writeln!(output, ", {least} to {greatest}{unit}")?,
                _ => writeln!(output)?,
            }
        }
        if own.other_values > 0 {
            writeln!(
                output,
                "fields     {} of further fields",
                counted(own.other_values, "value")
            )?;
        }
        Ok(())
    }

    /// Writes the longest outages, ordered by time.
    fn write_outages(&self, output: &mut impl Write) -> io::Result<()> {
        let mut durations: Vec<_> = self.outages.iter().map(Outage::duration).collect();
        durations.sort_unstable();
        let least = durations.iter().rev().nth(OUTAGES_SHOWN - 1).copied();
        let is_shown = |outage: &&Outage| {
            outage.end.is_none() || least.is_none_or(|least| outage.duration() >= least)
        };
        let shown: Vec<_> = self.outages.iter().filter(is_shown).collect();
        for outage in &shown {
            writeln!(output, "outage     {outage}")?;
        }
        match self.outages.len() - shown.len() {
            0 => Ok(()),
            shorter => writeln!(output, "outages    {shorter} more, shorter"),
        }
    }

    /// Writes the summary as text, one fact per line.
    ///
    /// # Errors
    /// If writing the output fails.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        self.write_origin(output)?;
        write!(output, "duration   {}", duration_words(self.duration_s))?;
        match self.robot_clock_s.map(|s| s as f64) {
            Some(clock_s) if clock_s > self.duration_s * PAUSES_FACTOR + PAUSES_S => {
                writeln!(
                    output,
                    " without the pauses, {} by the robot's clock",
                    duration_words(clock_s)
                )?;
            }
            _ => writeln!(output)?,
        }
        self.write_received(output)?;
        self.write_own(output)?;
        self.write_outages(output)?;
        if let Some(resync) = self.resync {
            writeln!(
                output,
                "resync     {}, {:.0} bytes on average, {} at worst",
                counted(resync.count, "time"),
                resync.mean_bytes,
                resync.worst_bytes
            )?;
        }
        if let Some(down_pct) = self.airtime_down_pct {
            write!(output, "airtime    {down_pct:.1} % down")?;
            if let Some(up_pct) = self.sent.and_then(|sent| sent.airtime_up_pct) {
                write!(output, ", {up_pct:.1} % up")?;
            }
            writeln!(output)?;
        }
        if let Some(sent) = self.sent.filter(|sent| sent.bytes > 0) {
            writeln!(
                output,
                "sent       {}, {}, {} of them again",
                counted(sent.bytes, "byte"),
                counted(sent.frames, "frame"),
                sent.frames_again
            )?;
        }
        if let Some(robot) = &self.robot {
            writeln!(
                output,
                "robot      {}, firmware {}, restarts {}",
                robot.id, robot.firmware_version, self.restarts
            )?;
        }
        // A robot with lines of its own has no bumpers, and need not say where it is.
        let is_own = self.is_own();
        if !is_own || self.distance_in > 0.0 {
            writeln!(output, "distance   {:.1} in", self.distance_in)?;
        }
        if !is_own {
            writeln!(output, "bumps      {}", self.bumps)?;
        }
        if let (Some(first), Some(last)) = (self.battery_first_v, self.battery_last_v) {
            writeln!(
                output,
                "battery    {first:.1} V at first, {last:.1} V at last"
            )?;
        }
        if !self.holders.is_empty() {
            let shares: Vec<_> = self
                .holders
                .iter()
                .map(|h| format!("{} {:.1} %", h.holder, h.share_pct))
                .collect();
            writeln!(output, "behaviours {}", shares.join(", "))?;
        }
        if let Some(problem) = &self.problem {
            writeln!(output, "problem    {problem}")?;
        }
        Ok(())
    }
}

/// Duration as `5 min 5.3 s`; from an hour on as `23 h 56 min 57 s`.
fn duration_words(duration_s: f64) -> String {
    // Round first, so that 119.97 s are 2 minutes.
    let tenths = (duration_s * 10.0).round() as u64;
    if tenths < 36_000 {
        return format!(
            "{} min {}.{} s",
            tenths / 600,
            tenths / 10 % 60,
            tenths % 10
        );
    }
    let s = duration_s.round() as u64;
    format!("{} h {} min {} s", s / 3600, s / 60 % 60, s % 60)
}

#[cfg(test)]
mod tests {
    use super::duration_words;

    #[test]
    fn durations_have_minutes_or_hours() {
        for (duration_s, words) in [
            (0.04, "0 min 0.0 s"),
            (119.97, "2 min 0.0 s"),
            (305.3, "5 min 5.3 s"),
            (3599.94, "59 min 59.9 s"),
            (3599.96, "1 h 0 min 0 s"),
            (86_217.0, "23 h 56 min 57 s"),
        ] {
            assert_eq!(duration_words(duration_s), words);
        }
    }
}
