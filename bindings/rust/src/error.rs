// SPDX-License-Identifier: MIT
//! Errors: a status of the library, and its text.

use std::ffi::CStr;
use std::fmt;

use crate::ffi;

/// What went wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A value is out of its range, or counts do not fit each other.
    Argument,
    /// A struct has a size that the library does not know: the library is older than this crate.
    StructSize,
    /// A triangle names a vertex that does not exist.
    IndexRange,
    /// An allocation failed, or a `memory_limit` was reached.
    OutOfMemory,
    /// More triangles, rays or pixels than 32-bit counts allow.
    TooLarge,
    /// A camera of size zero, a crop outside of it, numbers that are not finite, or parallel `dx` and `dy`.
    Camera,
    /// An instruction set that this machine does not have, or a method of the other kind of tree.
    Unsupported,
    /// The system would not start a thread.
    Thread,
    /// A callback asked to stop.
    Cancelled,
    /// The bytes are no saved tree, or a damaged one, or one of another version or of other triangles.
    Data,
    /// A status that this crate does not know, of a newer library.
    Other,
}

/// A failed call: its status, and a sentence that names the argument, its value and the rule that it breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    status: i32,
    message: String,
}

/// What a call that can fail returns.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn argument(message: String) -> Error {
        Error { status: ffi::MLRT_ERROR_ARGUMENT, message }
    }

    pub(crate) fn out_of_memory(message: String) -> Error {
        Error { status: ffi::MLRT_ERROR_OUT_OF_MEMORY, message }
    }

    /// The number of rays or points, which must be one that the library can count.
    pub(crate) fn check_count(name: &str, count: usize) -> Result<()> {
        if count <= i32::MAX as usize {
            return Ok(());
        }
        Err(Error { status: ffi::MLRT_ERROR_TOO_LARGE, message: format!("{name}: {count} is more than {}", i32::MAX) })
    }

    /// The status of the C interface: one of `ffi::MLRT_ERROR_*`.
    pub fn status(&self) -> i32 {
        self.status
    }

    /// The status as a kind.
    pub fn kind(&self) -> ErrorKind {
        match self.status {
            ffi::MLRT_ERROR_ARGUMENT => ErrorKind::Argument,
            ffi::MLRT_ERROR_STRUCT_SIZE => ErrorKind::StructSize,
            ffi::MLRT_ERROR_INDEX_RANGE => ErrorKind::IndexRange,
            ffi::MLRT_ERROR_OUT_OF_MEMORY => ErrorKind::OutOfMemory,
            ffi::MLRT_ERROR_TOO_LARGE => ErrorKind::TooLarge,
            ffi::MLRT_ERROR_CAMERA => ErrorKind::Camera,
            ffi::MLRT_ERROR_UNSUPPORTED => ErrorKind::Unsupported,
            ffi::MLRT_ERROR_THREAD => ErrorKind::Thread,
            ffi::MLRT_ERROR_CANCELLED => ErrorKind::Cancelled,
            ffi::MLRT_ERROR_DATA => ErrorKind::Data,
            _ => ErrorKind::Other,
        }
    }

    /// Which argument, which value, which rule; empty if there is nothing to say beyond the status.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // SAFETY: the string is never NULL, and static.
        let text = unsafe { CStr::from_ptr(ffi::mlrt_status_string(self.status)) }.to_string_lossy();
        if self.message.is_empty() {
            f.write_str(&text)
        } else {
            write!(f, "{text}: {}", self.message)
        }
    }
}

impl std::error::Error for Error {}

/// The result of a call that has just returned `status` to this thread.
pub(crate) fn check(status: i32) -> Result<()> {
    if status == ffi::MLRT_OK {
        return Ok(());
    }
    // SAFETY: the string is valid until the next call of this thread that fails.
    let message = unsafe { CStr::from_ptr(ffi::mlrt_last_message()) }.to_string_lossy().into_owned();
    Err(Error { status, message })
}
