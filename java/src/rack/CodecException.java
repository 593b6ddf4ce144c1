package rack;

/** Bytes that are not this struct, or values that it cannot hold. */
public final class CodecException extends RuntimeException {
  private static final long serialVersionUID = 1;

  CodecException(String text) {
    super(text);
  }
}
