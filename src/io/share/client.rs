//! One connection to a shared link.

use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadHalf, WriteHalf};
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::outbox::{Cut, Next, Outbox};
use super::{CLIENTS_MAX, FromClient, READ_MAX};
use crate::share::{ClientId, Lines, StationLine};

/// How long a closed client may take to hear why.
const LINGER: Duration = Duration::from_secs(1);

/// Either kind of socket.
pub(super) trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// How a connection ended.
pub(super) enum Ended {
    Gone,
    Cut(Cut),
}

/// Until the client is gone, closed or too slow.
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

/// Says that there is no room.
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
            // It has nothing to say and may go on reading, as `nc` does at the end of its input.
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

/// Reads on for a moment: a socket that is closed over unread bytes may lose what was written last.
async fn linger(reading: &mut ReadHalf<Box<dyn Stream>>, writing: &mut WriteHalf<Box<dyn Stream>>) {
    let rest = async {
        writing.shutdown().await?;
        tokio::io::copy(reading, &mut tokio::io::sink()).await
    };
    // It has had its chance.
    let _ = timeout(LINGER, rest).await;
}
