//! Archives whose bytes follow from what is in them.

use std::io::{self, Seek, SeekFrom, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System};

/// Stored: numbers hardly pack, and deflating a wash's takes longer than a step; pictures are packed already. Time,
/// rights and system are fixed, so that only the contents decide the archive's bytes. `bytes` is an upper bound.
pub(crate) fn stored(bytes: u64) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644)
        .system(System::Unix)
        .large_file(bytes >= u64::from(u32::MAX))
}

/// What an archive's failure is to a writer.
pub(crate) fn fault(error: ZipError) -> io::Error {
    match error {
        ZipError::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// A writer that reports its first failure and from then on only pretends to write.
///
/// An archive that is dropped before its end writes that end, and complains on standard error if it cannot: no
/// business of a library's.
pub(crate) struct Guarded<W> {
    inner: W,
    has_failed: bool,
    /// Where it is, and how far it ever was: an archive relies on both.
    at: u64,
    end: u64,
}

impl<W> Guarded<W> {
    /// Around a writer at its beginning.
    pub(crate) fn new(inner: W) -> Self {
        Self { inner, has_failed: false, at: 0, end: 0 }
    }

    /// Remembers whether it failed for good.
    fn seen<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        self.has_failed = matches!(&result, Err(error) if error.kind() != io::ErrorKind::Interrupted);
        result
    }

    fn go_to(&mut self, at: u64) {
        self.at = at;
        self.end = self.end.max(at);
    }
}

impl<W: Write> Write for Guarded<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = if self.has_failed { Ok(bytes.len()) } else { self.inner.write(bytes) };
        let written = match result {
            Ok(0) if !bytes.is_empty() => self.seen(Err(io::ErrorKind::WriteZero.into())),
            result if self.has_failed => result,
            result => self.seen(result),
        }?;
        self.go_to(self.at.saturating_add(written as u64));
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.has_failed {
            return Ok(());
        }
        let result = self.inner.flush();
        self.seen(result)
    }
}

impl<W: Seek> Seek for Guarded<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = if self.has_failed {
            match to {
                SeekFrom::Start(at) => at,
                SeekFrom::Current(by) => self.at.saturating_add_signed(by),
                SeekFrom::End(by) => self.end.saturating_add_signed(by),
            }
        } else {
            let result = self.inner.seek(to);
            self.seen(result)?
        };
        self.go_to(at);
        Ok(at)
    }
}
