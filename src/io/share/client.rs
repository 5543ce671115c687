//! One connection to a shared link.

use std::io;
use std::time::{Duration, Instant};

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadHalf, WriteHalf};
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::FromClient;
use super::outbox::{Cut, Next, Outbox};
use super::owner::Token;
use crate::share::{ClientId, LINE_MAX, Lines, StationLine};

/// Maximum number of bytes read ahead from a client.
const READ_MAX: usize = LINE_MAX;

/// Time for a closed client to read its last lines.
const LINGER: Duration = Duration::from_secs(1);

/// Time for a client to send its token.
const TOKEN_TIMEOUT: Duration = Duration::from_secs(5);

/// Maximum length of a first line, bytes.
const TOKEN_LINE_MAX: usize = 256;

/// A TCP or Unix socket.
pub(super) trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// The end of a connection.
pub(super) enum Ended {
    Gone,
    Cut(Cut),
}

/// Serves a client until it disconnects, is closed or is too slow.
pub(super) async fn serve(
    stream: Box<dyn Stream>,
    client: ClientId,
    outbox: &Outbox,
    to_station: &mpsc::Sender<FromClient>,
) -> Ended {
    let (mut reading, mut writing) = tokio::io::split(stream);
    let ended = tokio::select! {
        biased;
        cut = outbox.cut() => Ended::Cut(cut),
        () = listen(&mut reading, client, outbox, to_station) => Ended::Gone,
        written = write(&mut writing, outbox) => {
            if written.is_ok() {
                linger(&mut reading, &mut writing).await;
            }
            Ended::Gone
        }
    };
    if matches!(ended, Ended::Cut(Cut::GaveWay)) && outbox.converses() {
        let why = "this program was idle and made room for another; connect again to go on";
        tokio::spawn(dismiss(reading, writing, "gave-way", why.to_owned()));
    }
    ended
}

/// Returns the stream of a client whose first line is the token; sends instructions to other clients.
pub(super) async fn admit(mut stream: Box<dyn Stream>, token: &Token) -> Option<Box<dyn Stream>> {
    let line = async {
        let mut line = Vec::new();
        while line.len() < TOKEN_LINE_MAX {
            match stream.read_u8().await? {
                b'\n' => break,
                byte => line.push(byte),
            }
        }
        io::Result::Ok(line)
    };
    match timeout(TOKEN_TIMEOUT, line).await {
        Ok(Ok(line)) if token.is(&line) => Some(stream),
        Ok(Err(_)) => None,
        Ok(Ok(_)) | Err(_) => {
            let (reading, writing) = tokio::io::split(stream);
            dismiss(reading, writing, "token", token.how_to_show()).await;
            None
        }
    }
}

/// Ends a connection, with the reason as the last line.
async fn dismiss(
    mut reading: ReadHalf<Box<dyn Stream>>,
    mut writing: WriteHalf<Box<dyn Stream>>,
    code: &'static str,
    why: String,
) {
    let line = StationLine::error(code, why).to_line();
    if let Ok(Ok(())) = timeout(LINGER, writing.write_all(&line)).await {
        linger(&mut reading, &mut writing).await;
    }
}

async fn listen(
    reading: &mut ReadHalf<Box<dyn Stream>>,
    client: ClientId,
    outbox: &Outbox,
    to_station: &mpsc::Sender<FromClient>,
) {
    let mut lines = Lines::default();
    let mut buffer = vec![0; READ_MAX];
    loop {
        let count = match reading.read(&mut buffer).await {
            // A client that only receives may close its sending side, as `nc` does at the end of its input.
            Ok(0) if !outbox.converses() => std::future::pending().await,
            Ok(0) | Err(_) => return,
            Ok(count) => count,
        };
        let mut bytes = &buffer[..count];
        while !bytes.is_empty() {
            let (taken, line) = lines.take(bytes);
            bytes = &bytes[taken..];
            outbox.touch(Instant::now());
            if let Some(line) = line.transpose()
                && to_station
                    .send(FromClient::Line { client, line })
                    .await
                    .is_err()
            {
                return;
            }
        }
    }
}

async fn write(writing: &mut WriteHalf<Box<dyn Stream>>, outbox: &Outbox) -> io::Result<()> {
    loop {
        match outbox.next().await {
            Next::Write(bytes) => {
                writing.write_all(&bytes).await?;
                outbox.taken(Instant::now());
            }
            Next::Close => return Ok(()),
        }
    }
}

/// Reads briefly before closing: closing a socket with unread bytes may lose the bytes written last.
async fn linger(reading: &mut ReadHalf<Box<dyn Stream>>, writing: &mut WriteHalf<Box<dyn Stream>>) {
    let rest = async {
        writing.shutdown().await?;
        tokio::io::copy(reading, &mut tokio::io::sink()).await
    };
    // A client that does not close in time is dropped.
    let _ = timeout(LINGER, rest).await;
}
