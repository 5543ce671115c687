//! Keeps what the radio delivers, before anybody looks at it.

use std::collections::BTreeMap;
use std::path::{self, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Instant, SystemTime};

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::Decoder;

use super::driver::SentSink;
use crate::capture::{CaptureError, Existing, RawWriter, Recorder, Session};
use crate::event::{Moment, Recording};
use crate::io::link::Sink;

/// What to keep, and where.
#[derive(Clone, Debug)]
pub struct KeepOptions {
    /// Raw bytes go here.
    pub tee: Option<PathBuf>,
    /// MCAP goes here.
    pub mcap: Option<PathBuf>,
    /// What to do with files that exist.
    pub existing: Existing,
    /// The link as the operator named it.
    pub link: String,
    /// What else the recording shall say about itself.
    pub notes: BTreeMap<String, String>,
}

/// The raw tee and the MCAP recorder behind one lock: the reader thread writes received bytes, the
/// event loop what is sent.
#[derive(Clone)]
pub struct Keeper(Arc<Mutex<Inner>>);

struct Inner {
    tee: Option<RawWriter>,
    recorder: Option<Recorder>,
    /// Received and not yet with the recorder: it gets whole lines, however the bytes arrive.
    pending: Vec<u8>,
    decoder: Decoder,
    started: Instant,
    started_wall: SystemTime,
}

impl Keeper {
    /// Creates the files: all of them or none.
    ///
    /// # Errors
    /// When one of them exists and may not be touched, or cannot be written.
    pub fn open(options: &KeepOptions, started: Instant) -> Result<Self, CaptureError> {
        let started_wall = SystemTime::now();
        if let (Some(tee), Some(mcap)) = (&options.tee, &options.mcap)
            && path::absolute(tee).ok() == path::absolute(mcap).ok()
        {
            return Err(CaptureError::SameFile(tee.clone()));
        }
        let session = Session {
            link: options.link.clone(),
            start: started_wall,
            notes: options.notes.clone(),
        };
        // Only raw captures can be written on.
        let existing = match options.existing {
            Existing::Append => Existing::Refuse,
            other => other,
        };
        let recorder = options
            .mcap
            .as_ref()
            .map(|path| Recorder::start(path, existing, &session))
            .transpose()?;
        // Last, for this one cannot be taken back: it may write over what was there.
        let tee = options
            .tee
            .as_ref()
            .map(|path| RawWriter::create(path, options.existing))
            .transpose();
        let tee = match tee {
            Ok(tee) => tee,
            Err(error) => {
                if let Some(recorder) = recorder {
                    recorder.discard();
                }
                return Err(error);
            }
        };
        Ok(Self(Arc::new(Mutex::new(Inner {
            tee,
            recorder,
            pending: Vec::new(),
            decoder: Decoder::default(),
            started,
            started_wall,
        }))))
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For the link's reader thread.
    #[must_use]
    pub fn sink(&self) -> Sink {
        let keeper = self.clone();
        Box::new(move |at, bytes| keeper.lock().handle_rx(at, bytes))
    }

    /// For the driver, which sends.
    #[must_use]
    pub fn sent_sink(&self) -> SentSink {
        let keeper = self.clone();
        Box::new(move |at, bytes| keeper.lock().handle_tx(at, bytes))
    }

    /// What has been kept so far, and what went wrong.
    #[must_use]
    pub fn status(&self) -> Recording {
        self.lock().status()
    }

    /// Ends the recording in good order; returns the bytes that are in the files.
    ///
    /// # Errors
    /// Whatever went wrong since the start.
    pub fn finish(&self) -> Result<u64, CaptureError> {
        let (recorder, tee) = {
            let mut inner = self.lock();
            inner.hand_over(Instant::now());
            (inner.recorder.take(), inner.tee.take())
        };
        // Each is finished whatever became of the other.
        let teed = tee.map_or(Ok(0), RawWriter::finish);
        let recorded = recorder.map_or(Ok(0), Recorder::finish);
        Ok(recorded? + teed?)
    }

    /// Ends the recording when the guard goes, however its scope is left.
    #[must_use]
    pub fn finish_on_drop(&self) -> FinishOnDrop {
        FinishOnDrop(self.clone())
    }
}

/// Ends a recording in good order even when the program panics.
pub struct FinishOnDrop(Keeper);

impl Drop for FinishOnDrop {
    fn drop(&mut self) {
        // Who can report a failure has called `finish` before.
        let _ = self.0.finish();
    }
}

impl Inner {
    fn times(&self, at: Instant) -> (Moment, SystemTime) {
        let now = at.saturating_duration_since(self.started);
        (now, self.started_wall + now)
    }

    fn handle_rx(&mut self, at: Instant, bytes: &[u8]) {
        if let Some(tee) = &mut self.tee {
            tee.write(bytes);
        }
        if self.recorder.is_none() {
            return;
        }
        for &byte in bytes {
            self.pending.push(byte);
            if byte == b'\n' || self.pending.len() >= LINE_BYTES {
                self.hand_over(at);
            }
        }
    }

    /// One message for each line: a serial port hands over single bytes, and a message each would make
    /// the file ten times as long.
    fn hand_over(&mut self, at: Instant) {
        let (now, wall) = self.times(at);
        let pending = std::mem::take(&mut self.pending);
        let Some(recorder) = self.recorder.as_mut().filter(|_| !pending.is_empty()) else {
            return;
        };
        recorder.handle_rx(now, wall, &pending);
        let mut bytes = &pending[..];
        while !bytes.is_empty() {
            let (taken, received) = self.decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            if let Some(received) = received {
                recorder.handle_line(now, wall, &received);
            }
        }
        recorder.handle_timeout(now);
    }

    fn handle_tx(&mut self, at: Instant, bytes: &[u8]) {
        let (now, wall) = self.times(at);
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_tx(now, wall, bytes);
        }
    }

    fn status(&mut self) -> Recording {
        // On a silent link nothing else reminds the recorder of what waits to be flushed.
        let (now, _) = self.times(Instant::now());
        if let Some(recorder) = &mut self.recorder {
            recorder.handle_timeout(now);
        }
        let name = |path: &path::Path| path.display().to_string();
        let tee_problem = self.tee.as_ref().and_then(RawWriter::problem);
        let recorder_problem = self.recorder.as_ref().and_then(Recorder::problem);
        Recording {
            tee: self.tee.as_ref().map(|tee| name(tee.path())),
            mcap: self.recorder.as_ref().map(|recorder| name(recorder.path())),
            bytes: match (&self.recorder, &self.tee) {
                (Some(recorder), _) => recorder.bytes(),
                (None, Some(tee)) => tee.bytes(),
                (None, None) => 0,
            },
            problem: tee_problem.or(recorder_problem),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_leaves_a_finished_recording() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let options = KeepOptions {
            tee: None,
            mcap: Some(path.clone()),
            existing: Existing::Refuse,
            link: "sim".to_owned(),
            notes: BTreeMap::new(),
        };
        let keeper = Keeper::open(&options, Instant::now()).unwrap();
        // The reader thread of the link holds on to this.
        let _sink = keeper.sink();
        let panicked = std::panic::catch_unwind(|| {
            let _finish = keeper.finish_on_drop();
            panic!("this is the panic that was asked for");
        });
        assert!(panicked.is_err());
        assert!(path.exists());
    }
}
