/** A call of the library that failed. The message is the library's own: a sentence that names the control, the field or
 * the byte offset. */
export class FaceBakerError extends Error {
  /** As in facebaker.h: 1 invalid argument, 2 not found, 3 IO, 4 not an archive, 5 corrupt, ... */
  readonly status: number;
  /** The constant's name, such as "FB_ERROR_CORRUPT". */
  readonly statusName: string;

  constructor(status: number, statusName: string, message: string) {
    super(message);
    this.name = "FaceBakerError";
    this.status = status;
    this.statusName = statusName;
  }
}

export const invalidArgument = (message: string): FaceBakerError =>
  new FaceBakerError(1, "FB_ERROR_INVALID_ARGUMENT", message);
export const notRead = (message: string): FaceBakerError => new FaceBakerError(3, "FB_ERROR_IO", message);
