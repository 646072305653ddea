using System;

namespace FaceBaker
{
    /// <summary>Why a call failed, with the numbers of the C interface.</summary>
    public enum Status
    {
        /// <summary>Success.</summary>
        Ok = Native.FB_OK,
        /// <summary>A buffer of the wrong size, an index out of range, a value that is not allowed.</summary>
        InvalidArgument = Native.FB_ERROR_INVALID_ARGUMENT,
        /// <summary>There is no such file, control, mesh, socket, channel or joint.</summary>
        NotFound = Native.FB_ERROR_NOT_FOUND,
        /// <summary>The system refused a read, or a stream failed.</summary>
        IO = Native.FB_ERROR_IO,
        /// <summary>The bytes are no .fbk archive.</summary>
        NotAnArchive = Native.FB_ERROR_NOT_AN_ARCHIVE,
        /// <summary>The archive is truncated or damaged.</summary>
        Corrupt = Native.FB_ERROR_CORRUPT,
        /// <summary>The archive has another format version, or parts that the library does not know.</summary>
        Unsupported = Native.FB_ERROR_UNSUPPORTED,
        /// <summary>Larger than a limit of <see cref="LoadOptions"/>, or than sizes can be.</summary>
        Limit = Native.FB_ERROR_LIMIT,
        /// <summary>An allocation failed.</summary>
        OutOfMemory = Native.FB_ERROR_OUT_OF_MEMORY,
        /// <summary>NaN where a number is needed; the message names the control.</summary>
        NotFinite = Native.FB_ERROR_NOT_FINITE,
        /// <summary>Inconsistent data.</summary>
        BadData = Native.FB_ERROR_BAD_DATA,
        /// <summary>An error of the library itself.</summary>
        Internal = Native.FB_ERROR_INTERNAL
    }

    /// <summary>A call of the library failed. The message is the library's: a sentence that names the file, field, control or
    /// byte offset.</summary>
    [Serializable]
    public sealed class FaceBakerException : Exception
    {
        /// <summary>Made by the calls of this package.</summary>
        public FaceBakerException(Status status, string message) : base(message)
        {
            Status = status;
        }

        /// <summary>What kind of failure it is.</summary>
        public Status Status { get; private set; }
    }
}
