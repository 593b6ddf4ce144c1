package tims;

/** Bits of {@link Header#flags()}. */
public final class Flag {
  public static final int HEADER_LITTLE_ENDIAN = 0x01;
  public static final int BODY_LITTLE_ENDIAN = 0x02;
  /** A sample: a newer one may replace it on a slow link. */
  public static final int STREAM = 0x10;
  /** A receiver that refuses the command adds the reason to ERROR. */
  public static final int REPORT_REASON = 0x80;

  private Flag() {}
}
