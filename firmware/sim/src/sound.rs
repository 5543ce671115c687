//! The sound of the robot's beeper as a WAV file: mono, 16 bit.

use std::f64::consts::TAU;
use std::io::{self, Seek, Write};

use hound::{SampleFormat, WavSpec, WavWriter};
use sr04_firmware::song::NOTE_HZ_MAX;

use crate::time::TICK_MS;

/// Number of samples per second.
const SAMPLE_HZ: u32 = 22_050;

/// Number of ticks per second.
const TICK_HZ: u32 = 1000 / TICK_MS as u32;

/// Number of samples of fade-in and fade-out, 5 ms: a tone that starts abruptly would click.
const RAMP_SAMPLES: u16 = 110;

/// Amplitude of the loudest sample: small loudspeakers do not distort it.
const PEAK: f64 = 13_000.0;

/// Partials of the square wave that are sounded: three sound as harsh as a beeper in a box.
const PARTIALS: [u16; 3] = [1, 3, 5];

/// Maximum number of samples: a WAV file counts its bytes in 32 bits, header included. About 27 hours.
const SAMPLES_MAX: u32 = (u32::MAX - 1024) / 2;

/// Number of ticks between two updates of the file's header, 10 s: a killed program loses at most that much.
const WHOLE_EVERY_TICKS: u32 = 10 * TICK_HZ;

/// Writes the beeper's sound to a WAV file, tick by tick.
pub struct Sound<W: Write + Seek> {
    beeper: Beeper,
    out: WavWriter<W>,
    ticks: u32,
    samples_max: u32,
}

impl<W: Write + Seek> Sound<W> {
    /// Begins an empty WAV file. Wrap `out` in a buffer.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written, or cannot seek back to the header.
    pub fn new(mut out: W) -> io::Result<Self> {
        out.rewind()?;
        let spec = WavSpec {
            channels: 1,
            sample_rate: SAMPLE_HZ,
            bits_per_sample: 16,
            sample_format: SampleFormat::Int,
        };
        Ok(Self {
            beeper: Beeper::default(),
            out: WavWriter::new(out, spec).map_err(plain)?,
            ticks: 0,
            samples_max: SAMPLES_MAX,
        })
    }

    /// Sounds a note in hertz for one tick of 1/20 s; 0 is silence. Two ticks with the same note are one tone.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written, or the file has reached the maximum length of a WAV file.
    pub fn tick(&mut self, note_hz: u16) -> io::Result<()> {
        let samples = self.beeper.begin_tick(note_hz);
        self.write(samples)?;
        self.ticks += 1;
        if self.ticks.is_multiple_of(WHOLE_EVERY_TICKS) {
            self.out.flush().map_err(plain)?;
        }
        Ok(())
    }

    /// Fades the last tone out and completes the file.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        let samples = self.beeper.begin_fade();
        self.write(samples)?;
        self.out.finalize().map_err(plain)
    }

    fn write(&mut self, samples: u32) -> io::Result<()> {
        if self.out.len() + samples > self.samples_max {
            let problem = "the WAV file is full (4 GiB, about 27 hours); start a new one";
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem));
        }
        let mut block = self.out.get_i16_writer(samples);
        for _ in 0..samples {
            block.write_sample(self.beeper.next_sample());
        }
        block.flush().map_err(plain)
    }
}

fn plain(error: hound::Error) -> io::Error {
    match error {
        hound::Error::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// The beeper: a tone whose phase continues from note to note.
#[derive(Debug, Default)]
struct Beeper {
    is_on: bool,
    /// Frequency of the tone that sounds or fades.
    hz: u16,
    /// Phase in 1/2^32 of a turn.
    phase: u32,
    /// Position on the fade ramp, up to [`RAMP_SAMPLES`].
    level: u16,
    /// Remainder in 1/[`TICK_HZ`] samples carried to the next tick: a tick is no whole number of samples.
    left_over: u32,
}

impl Beeper {
    /// Starts a tick with this note and returns its number of samples.
    fn begin_tick(&mut self, note_hz: u16) -> u32 {
        self.is_on = note_hz > 0;
        if self.is_on {
            self.hz = note_hz.min(NOTE_HZ_MAX);
        }
        let parts = self.left_over + SAMPLE_HZ;
        self.left_over = parts % TICK_HZ;
        parts / TICK_HZ
    }

    /// Ends the tone and returns the number of samples that it fades.
    fn begin_fade(&mut self) -> u32 {
        self.is_on = false;
        u32::from(self.level)
    }

    fn next_sample(&mut self) -> i16 {
        self.level = if self.is_on {
            (self.level + 1).min(RAMP_SAMPLES)
        } else {
            self.level.saturating_sub(1)
        };
        if self.level == 0 {
            self.phase = 0;
            return 0;
        }
        let turn = f64::from(self.phase) / 2f64.powi(32);
        self.phase = self
            .phase
            .wrapping_add(((u64::from(self.hz) << 32) / u64::from(SAMPLE_HZ)) as u32);
        // Partials above half of the sampling rate would alias to other tones.
        let wave: f64 = PARTIALS
            .into_iter()
            .filter(|partial| u32::from(self.hz) * u32::from(*partial) < SAMPLE_HZ / 2)
            .map(|partial| libm::sin(TAU * turn * f64::from(partial)) / f64::from(partial))
            .sum();
        (wave * PEAK * f64::from(self.level) / f64::from(RAMP_SAMPLES)) as i16
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use hound::WavReader;
    use proptest::prelude::*;

    use super::*;

    fn sounded(notes: &[(u16, u8)]) -> Vec<i16> {
        let mut bytes = Cursor::new(Vec::new());
        let mut sound = Sound::new(&mut bytes).unwrap();
        for &(hz, ticks) in notes {
            for _ in 0..ticks {
                sound.tick(hz).unwrap();
            }
        }
        sound.finish().unwrap();
        let reader = WavReader::new(Cursor::new(bytes.into_inner())).unwrap();
        let spec = reader.spec();
        assert_eq!(
            (spec.channels, spec.sample_rate, spec.bits_per_sample),
            (1, 22_050, 16)
        );
        reader.into_samples().map(Result::unwrap).collect()
    }

    /// Frequency of a tone, from its rises through zero.
    fn frequency_hz(samples: &[i16]) -> f64 {
        let rises: Vec<usize> = (1..samples.len())
            .filter(|&n| samples[n - 1] < 0 && samples[n] >= 0)
            .collect();
        let (first, last) = (rises[0], rises[rises.len() - 1]);
        (rises.len() - 1) as f64 * f64::from(SAMPLE_HZ) / (last - first) as f64
    }

    /// Index of the first sample after `ticks` ticks.
    fn sample_at(ticks: usize) -> usize {
        ticks * SAMPLE_HZ as usize / TICK_HZ as usize
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn notes_have_their_pitch_and_length(
            notes in prop::collection::vec((prop_oneof![Just(0), 100u16..=NOTE_HZ_MAX], 4u8..=20), 1..=8)
        ) {
            let samples = sounded(&notes);
            let ticks: usize = notes.iter().map(|note| usize::from(note.1)).sum();
            let fade = samples.len() - sample_at(ticks);
            prop_assert!(fade <= usize::from(RAMP_SAMPLES), "{fade}");
            let mut begun = 0;
            for &(hz, length) in &notes {
                let note = &samples[sample_at(begun)..sample_at(begun + usize::from(length))];
                begun += usize::from(length);
                // The fade of the previous note is not part of this one.
                let held = &note[usize::from(RAMP_SAMPLES)..];
                if hz == 0 {
                    prop_assert!(held.iter().all(|&sample| sample == 0));
                    continue;
                }
                let heard_hz = frequency_hz(held);
                prop_assert!((heard_hz / f64::from(hz) - 1.0).abs() < 0.01, "{heard_hz} for {hz}");
                prop_assert!(held.iter().any(|sample| f64::from(sample.abs()) > PEAK / 2.0));
            }
        }

        /// A click is a step that no tone has by itself. Low tones are smooth and end anywhere in their turn.
        #[test]
        fn notes_begin_end_and_change_without_clicks(
            notes in prop::collection::vec((prop_oneof![Just(0), 100u16..=400], 1u8..=4), 1..=20)
        ) {
            let samples = sounded(&notes);
            let steepest = PEAK * TAU * 400.0 / f64::from(SAMPLE_HZ) * PARTIALS.len() as f64;
            let ramp = PEAK / 100.0;
            prop_assert_eq!((samples[0], samples[samples.len() - 1]), (0, 0));
            for pair in samples.windows(2) {
                let step = f64::from(pair[1]) - f64::from(pair[0]);
                prop_assert!(step.abs() <= steepest + ramp + 1.0, "{pair:?}");
            }
        }
    }

    #[test]
    fn twenty_ticks_are_one_second_of_samples() {
        assert_eq!(sounded(&[(0, 20)]).len(), 22_050);
        assert_eq!(sounded(&[(0, 7)]).len(), sample_at(7));
    }

    #[test]
    fn full_file_reports_an_error_and_stays_valid() {
        let mut bytes = Cursor::new(Vec::new());
        let mut sound = Sound::new(&mut bytes).unwrap();
        sound.samples_max = 5000;
        let error = (0..9).find_map(|_| sound.tick(440).err()).unwrap();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        drop(sound);
        let reader = WavReader::new(Cursor::new(bytes.into_inner())).unwrap();
        assert_eq!(reader.len() as usize, sample_at(4));
    }

    /// Reads the file as a killed program leaves it.
    #[test]
    fn file_is_valid_every_ten_seconds() {
        let path =
            std::env::temp_dir().join(format!("groundwave-sound-{}.wav", std::process::id()));
        let file = io::BufWriter::new(std::fs::File::create(&path).unwrap());
        let mut sound = Sound::new(file).unwrap();
        for _ in 0..250 {
            sound.tick(440).unwrap();
        }
        let so_far = WavReader::open(&path).unwrap().len();
        drop(sound);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(so_far, 10 * SAMPLE_HZ);
    }
}
