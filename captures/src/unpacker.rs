//! What a chunk of an MCAP holds, believed when its checksum holds.

use super::repair::Problem;
use super::writer::records::Reader;

/// Unpacks chunks one after the other: making what decompresses them takes longer than a small chunk.
#[derive(Default)]
pub(super) struct Unpacker {
    zstd: Option<zstd::bulk::Decompressor<'static>>,
}

/// Another one is made when it is needed.
impl Clone for Unpacker {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Why a chunk is lost, and first and last log time of its messages where it still says them.
pub(super) type Lost = (Problem, Option<(u64, u64)>);

impl Unpacker {
    /// Puts what a chunk holds into `content`. `body` is its record without operation code and length; one that
    /// says that it holds more than `bytes_max` is not believed.
    ///
    /// # Errors
    /// What does not hold; `content` is of no use then.
    pub(super) fn unpack(
        &mut self,
        body: &[u8],
        bytes_max: usize,
        content: &mut Vec<u8>,
    ) -> Result<(), Lost> {
        let header = Header::read(body).ok_or((Problem::Flaw("a chunk makes no sense"), None))?;
        self.decompress(&header, bytes_max, content)
            .map_err(|problem| (problem, Some(header.times_ns)))
    }

    fn decompress(
        &mut self,
        header: &Header<'_>,
        bytes_max: usize,
        content: &mut Vec<u8>,
    ) -> Result<(), Problem> {
        let bytes = usize::try_from(header.bytes).ok();
        let Some(bytes) = bytes.filter(|bytes| *bytes <= bytes_max) else {
            return Err("a chunk claims to be larger than any".into());
        };
        content.clear();
        match header.compression {
            "" => content.extend_from_slice(header.data),
            "zstd" => {
                content.reserve(bytes);
                let zstd = match &mut self.zstd {
                    Some(zstd) => zstd,
                    none => none.insert(
                        zstd::bulk::Decompressor::new()
                            .map_err(|_| "a chunk cannot be unpacked")?,
                    ),
                };
                zstd.decompress_to_buffer(header.data, content)
                    .map_err(|_| "a chunk cannot be unpacked")?;
            }
            "lz4" => return Err(Problem::Lz4),
            _ => return Err("a chunk is compressed with something else than zstd".into()),
        }
        if content.len() != bytes {
            return Err("a chunk has another length than it says".into());
        }
        if header.crc != 0 && crc32fast::hash(content) != header.crc {
            return Err("the checksum of a chunk does not hold".into());
        }
        Ok(())
    }
}

/// What a chunk says of itself.
pub(super) struct Header<'a> {
    /// First and last log time of its messages.
    pub(super) times_ns: (u64, u64),
    bytes: u64,
    crc: u32,
    pub(super) compression: &'a str,
    /// What it holds, compressed.
    pub(super) data: &'a [u8],
}

impl<'a> Header<'a> {
    /// That of a chunk record without operation code and length; `None` where it cannot be one.
    pub(super) fn read(body: &'a [u8]) -> Option<Self> {
        let mut fields = Reader(body);
        let header = Self {
            times_ns: (fields.u64()?, fields.u64()?),
            bytes: fields.u64()?,
            crc: fields.u32()?,
            compression: fields.text()?,
            data: {
                let length = usize::try_from(fields.u64()?).ok()?;
                fields.take(length)?
            },
        };
        fields.0.is_empty().then_some(header)
    }
}
