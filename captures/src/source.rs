//! Reads captures of either form.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use groundwave_protocol::decoder::{Counters, Decoder, Received};

use super::CaptureError;
use super::chunk::Chunk;
use super::files::{self, is_in_use};
use super::interrupted::is_unfinished;
use super::marks::Marks;
use super::mcap_reader::Damages;
use super::name::utc;
use super::pieces::{Piece, Pieces, has_received};
use super::session::Session;
use super::text::TextReader;
use super::topics::RAW_RX;
use crate::outages::{Outage, OutageList};
use crate::statistics::Uplink;

/// Form of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Raw text: the bytes alone.
    Raw,
    /// MCAP: bytes with times, and station events.
    Mcap,
}

/// Number of bytes at the beginning of a capture that determine its form.
pub const HEAD_BYTES: usize = ::mcap::MAGIC.len();

impl Form {
    /// The form of a capture, from its first [`HEAD_BYTES`] bytes, or fewer if the capture is shorter.
    #[must_use]
    pub fn tell(head: &[u8]) -> Self {
        if head == ::mcap::MAGIC {
            return Self::Mcap;
        }
        Self::Raw
    }
}

/// Number of bytes at the beginning of a file that are examined for a route.
pub(super) const ROUTE_HEAD_BYTES: usize = 1024;

/// Whether a file is a route, from its first [`ROUTE_HEAD_BYTES`] bytes, or fewer if the file is shorter. As a capture, a route
/// would be shown as noise.
pub(super) fn is_route(head: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(head) else {
        return false;
    };
    // The last line may continue after the head.
    let whole = match text.rfind('\n') {
        Some(end) if head.len() == ROUTE_HEAD_BYTES => &text[..end],
        _ => text,
    };
    let is_whole_inches = |text: &str| text.trim().parse::<i16>().is_ok();
    let mut lines = whole
        .trim_start_matches('\u{feff}')
        .lines()
        .filter_map(|line| line.split('#').next())
        .filter(|line| !line.trim().is_empty())
        .peekable();
    lines.peek().is_some()
        && lines.all(|line| {
            line.split_once(',')
                .is_some_and(|(x, y)| is_whole_inches(x) && is_whole_inches(y))
        })
}

/// Opens the file of a capture. Refuses a device, because its bytes may have no end.
///
/// # Errors
/// If the file cannot be opened.
pub fn open_file(path: &Path) -> Result<File, CaptureError> {
    let opened = if files::is_device(path) {
        Err(io::Error::other(
            "it is a device, whose bytes may have no end; record them first: groundwave record DEVICE",
        ))
    } else {
        files::open(path)
    };
    opened.map_err(|error| CaptureError::Open {
        path: path.to_owned(),
        error,
    })
}

/// The error for a recording that is in progress or was interrupted; `None` for other files.
#[must_use]
pub fn unfinished(path: &Path) -> Option<CaptureError> {
    is_unfinished(path).then(|| CaptureError::Unfinished {
        path: path.to_owned(),
        is_in_use: is_in_use(path),
    })
}

type Source = io::Chain<Cursor<Vec<u8>>, Box<dyn Read + Send>>;

enum Reader {
    Raw(TextReader<Source>),
    Mcap(Box<Pieces<Source>>),
}

/// An open capture, read from its beginning.
pub struct Capture {
    path: PathBuf,
    reader: Reader,
    end: Duration,
    /// Time of the latest message of any kind, since the capture began.
    latest: Duration,
    missing_bytes: u64,
    uplink: Uplink,
    marks: Marks,
    damages: Damages,
    has_verdict: bool,
    /// The chunk returned last.
    current: Vec<u8>,
}

impl Capture {
    /// Opens a capture; its content determines the form. `-` is standard input.
    ///
    /// # Errors
    /// If the file cannot be opened or read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, CaptureError> {
        let path = path.as_ref();
        if path == Path::new("-") {
            return Self::read("standard input", Box::new(io::stdin()));
        }
        Self::read(path, Box::new(open_file(path)?))
    }

    /// Reads a capture from any source; the name appears in error messages.
    ///
    /// # Errors
    /// If its beginning cannot be read.
    pub fn read(
        name: impl Into<PathBuf>,
        mut source: Box<dyn Read + Send>,
    ) -> Result<Self, CaptureError> {
        let path = name.into();
        let mut head = Vec::new();
        if let Err(error) = source
            .by_ref()
            .take(HEAD_BYTES as u64)
            .read_to_end(&mut head)
        {
            return Err(CaptureError::Read { path, error });
        }
        let form = Form::tell(&head);
        let source = Cursor::new(head).chain(source);
        let reader = match form {
            Form::Mcap => Reader::Mcap(Box::new(Pieces::new(source))),
            Form::Raw => Reader::Raw(TextReader::new(source)),
        };
        Ok(Self {
            path,
            reader,
            end: Duration::ZERO,
            latest: Duration::ZERO,
            missing_bytes: 0,
            uplink: Uplink::default(),
            marks: Marks::default(),
            damages: Damages::default(),
            has_verdict: false,
            current: Vec::new(),
        })
    }

    /// Form of the capture.
    #[must_use]
    pub const fn form(&self) -> Form {
        match self.reader {
            Reader::Raw(_) => Form::Raw,
            Reader::Mcap(_) => Form::Mcap,
        }
    }

    /// Describes how a raw capture differs from the radio's bytes; known after the first lines.
    #[must_use]
    pub fn stored(&self) -> Option<String> {
        match &self.reader {
            Reader::Raw(reader) => reader.judged()?.words(),
            Reader::Mcap(_) => None,
        }
    }

    /// Number of received bytes missing so far; 0 for a raw capture.
    #[must_use]
    pub const fn missing_bytes(&self) -> u64 {
        self.missing_bytes
    }

    /// Metadata of a recording read so far: `link`, `start` and others; `None` for a raw capture.
    #[must_use]
    pub fn session(&self) -> Option<&BTreeMap<String, String>> {
        match &self.reader {
            Reader::Raw(_) => None,
            Reader::Mcap(reader) => Some(reader.session()),
        }
    }

    /// Start in UTC, `2025-03-14T09:26:53Z`, once a piece has been read; `None` for raw text without dates.
    #[must_use]
    pub fn start(&self) -> Option<String> {
        let since_1970 = match &self.reader {
            Reader::Raw(reader) => reader.judged()?.unix()?,
            Reader::Mcap(reader) => Duration::from_nanos(reader.first_ns()?),
        };
        Some(utc(UNIX_EPOCH + since_1970))
    }

    /// Metadata of an MCAP before its next piece; `None` of a raw capture.
    ///
    /// # Errors
    /// The capture cannot be read.
    pub fn session_ahead(&mut self) -> Result<Option<BTreeMap<String, String>>, CaptureError> {
        if let Reader::Mcap(reader) = &mut self.reader {
            reader.next_ns().map_err(|error| CaptureError::Read {
                path: self.path.clone(),
                error,
            })?;
        }
        Ok(self.session().cloned())
    }

    /// Whether the time of the next piece was measured, unlike in raw text without timestamps. A time that was not measured shows no silence.
    ///
    /// # Errors
    /// The capture cannot be read.
    pub(crate) fn has_time_ahead(&mut self) -> Result<bool, CaptureError> {
        let ahead = match &mut self.reader {
            Reader::Raw(reader) => reader.style().map(drop),
            Reader::Mcap(reader) => reader.next_ns().map(drop),
        };
        ahead.map_err(|error| CaptureError::Read {
            path: self.path.clone(),
            error,
        })?;
        Ok(self.has_time())
    }

    /// Whether the time of the latest piece was measured.
    pub(crate) fn has_time(&self) -> bool {
        match &self.reader {
            Reader::Raw(reader) => reader.judged().is_some_and(|style| style.is_stamped()),
            Reader::Mcap(reader) => Session::has_times(reader.session()),
        }
    }

    /// Statistics of the bytes sent up to the piece read last; `None` for a raw capture.
    #[must_use]
    pub const fn uplink(&self) -> Option<&Uplink> {
        match &self.reader {
            Reader::Raw(_) => None,
            Reader::Mcap(_) => Some(&self.uplink),
        }
    }

    /// Marks set in the part that has been read.
    #[must_use]
    pub const fn marks(&self) -> &Marks {
        &self.marks
    }

    /// Time of the latest received bytes, since the capture began.
    #[must_use]
    pub const fn end(&self) -> Duration {
        self.end
    }

    /// Time of the latest message of any kind, since the capture began.
    pub(crate) fn latest(&self) -> Duration {
        self.latest.max(self.end)
    }

    /// The outages of a capture that has been read to its end, with one that lasts until the latest message of any kind; takes the decoder's totals until then.
    #[must_use]
    pub(crate) fn outages(&self, list: OutageList, counters: &Counters) -> Vec<Outage> {
        list.into_outages(self.latest(), counters)
    }

    /// The next piece and its time since the capture began; `None` at the end.
    ///
    /// # Errors
    /// If the capture cannot be read; also once, at the end, when parts of it were damaged.
    pub fn next_piece(&mut self) -> Result<Option<(Duration, Piece<'_>)>, CaptureError> {
        let read_error = |error| CaptureError::Read {
            path: self.path.clone(),
            error,
        };
        if let Reader::Mcap(reader) = &mut self.reader
            && reader.next_ns().map_err(read_error)?.is_none()
        {
            return self.verdict().map_or(Ok(None), Err);
        }
        let (at, piece) = match &mut self.reader {
            Reader::Raw(reader) => {
                let Some(piece) = reader.next_piece().map_err(read_error)? else {
                    return Ok(None);
                };
                (piece.at, Piece::Received(piece.radio))
            }
            Reader::Mcap(reader) => {
                let first_ns = reader.first_ns().unwrap_or(0);
                let Some((at_ns, piece)) = reader.next_piece().map_err(read_error)? else {
                    return Ok(None);
                };
                let since_first_ns = at_ns.saturating_sub(first_ns);
                (Duration::from_nanos(since_first_ns), piece)
            }
        };
        self.latest = at;
        match &piece {
            Piece::Sent(bytes) => self.uplink.take(at, bytes),
            Piece::Missing(bytes) => {
                self.missing_bytes = self.missing_bytes.saturating_add(*bytes);
            }
            Piece::Repeated(offset) => {
                let damage = format_args!("{RAW_RX}: the bytes at {offset} are repeated");
                self.damages.push(damage);
            }
            Piece::Damaged(damage) => self.damages.push(damage),
            Piece::Event(event) => {
                if let Some(mark) = event.mark() {
                    self.marks.take(at, mark);
                }
            }
            Piece::Received(_) => {}
        }
        Ok(Some((at, piece)))
    }

    /// Reason why a recording could not be read completely; returned once.
    fn verdict(&mut self) -> Option<CaptureError> {
        let Reader::Mcap(reader) = &self.reader else {
            return None;
        };
        if std::mem::replace(&mut self.has_verdict, true) {
            return None;
        }
        let path = self.path.clone();
        if !self.damages.is_empty() {
            let problem = self.damages.in_words();
            Some(CaptureError::Damaged { path, problem })
        } else if !reader.is_finished() {
            let is_in_use = is_in_use(&path);
            Some(CaptureError::Unfinished { path, is_in_use })
        } else if !has_received(reader.channels()) {
            Some(CaptureError::NoRawBytes(path))
        } else {
            None
        }
    }

    /// The next bytes from the robot; `None` at the end. A chunk without bytes says what came after the last ones.
    ///
    /// # Errors
    /// The errors of [`Self::next_piece`].
    pub fn next_chunk(&mut self) -> Result<Option<Chunk<'_>>, CaptureError> {
        let mut bytes = std::mem::take(&mut self.current);
        bytes.clear();
        let mut is_after_missing = false;
        let (mut unplugged_at, mut suspended_at) = (None, None);
        let at = loop {
            match self.next_piece()? {
                None if is_after_missing || unplugged_at.or(suspended_at).is_some() => {
                    break self.latest();
                }
                None => return Ok(None),
                Some((at, Piece::Received(received))) => {
                    bytes.extend_from_slice(received);
                    self.end = at;
                    break at;
                }
                Some((_, Piece::Missing(_) | Piece::Damaged(_))) => is_after_missing = true,
                Some((at, Piece::Event(event))) if event.is_loss_of_link() => {
                    unplugged_at.get_or_insert(at);
                }
                Some((at, Piece::Event(event))) => {
                    let since = event.suspension().map(|it| at.saturating_sub(it));
                    suspended_at = suspended_at.or(since);
                }
                Some((_, Piece::Sent(_) | Piece::Repeated(_))) => {}
            }
        };
        self.current = bytes;
        Ok(Some(Chunk {
            at,
            has_time: self.has_time(),
            bytes: &self.current,
            is_after_missing,
            unplugged_at,
            suspended_at,
            session: self.session(),
        }))
    }

    /// Decodes the whole capture; calls `take` with each line and the time of its end.
    ///
    /// # Errors
    /// The errors of the capture and of `take`.
    pub fn for_each_line<E: From<CaptureError>>(
        &mut self,
        decoder: &mut Decoder,
        mut take: impl FnMut(Duration, &Received) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut latest = Duration::ZERO;
        let end = loop {
            let chunk = match self.next_chunk() {
                Ok(Some(chunk)) => chunk,
                Ok(None) => break Ok(()),
                Err(error) => break Err(error),
            };
            chunk.tell(decoder);
            let mut bytes = chunk.bytes;
            while let Some(received) = decoder.next_own_line(&mut bytes) {
                take(chunk.at, &received)?;
            }
            latest = chunk.at;
        };
        for received in decoder.undecided_lines() {
            take(latest, &received)?;
        }
        Ok(end?)
    }
}
