//! One connection to a shared link.

use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadHalf, WriteHalf};
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::outbox::{Cut, Next, Outbox};
use super::{CLIENTS_MAX, FromClient, READ_MAX};
use crate::share::{ClientId, Lines, StationLine};

/// Time for a closed client to read its last lines.
const LINGER: Duration = Duration::from_secs(1);

/// A TCP or Unix socket.
pub(super) trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// How a connection ended.
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
        cut = outbox.cut() => return Ended::Cut(cut),
        () = listen(&mut reading, client, outbox, to_station) => return Ended::Gone,
        written = write(&mut writing, outbox) => written,
    };
    if ended.is_ok() {
        linger(&mut reading, &mut writing).await;
    }
    Ended::Gone
}

/// Refuses a client because there are too many.
pub(super) async fn turn_away(stream: Box<dyn Stream>) {
    let (mut reading, mut writing) = tokio::io::split(stream);
    let full = StationLine::Error {
        error: format!("{CLIENTS_MAX} programs share this link already"),
    };
    if writing.write_all(&full.to_line()).await.is_ok() {
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

async fn write(writing: &mut WriteHalf<Box<dyn Stream>>, outbox: &Outbox) -> std::io::Result<()> {
    loop {
        match outbox.next().await {
            Next::Write(bytes) => writing.write_all(&bytes).await?,
            Next::Close => return Ok(()),
        }
    }
}

/// Reads for a moment before closing: closing a socket with unread bytes may lose the bytes written last.
async fn linger(reading: &mut ReadHalf<Box<dyn Stream>>, writing: &mut WriteHalf<Box<dyn Stream>>) {
    let rest = async {
        writing.shutdown().await?;
        tokio::io::copy(reading, &mut tokio::io::sink()).await
    };
    // A client that does not close in time is dropped.
    let _ = timeout(LINGER, rest).await;
}
