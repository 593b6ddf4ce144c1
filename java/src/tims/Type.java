package tims;

/** Types of messages that have a meaning for all mailboxes. */
public final class Type {
  public static final int OK = 0;
  public static final int ERROR = -1;
  public static final int TIMEOUT = -2;
  public static final int NOT_AVAILABLE = -3;
  public static final int ENABLED = -4;
  public static final int DISABLED = -5;
  public static final int DATA = -6;
  public static final int CONT_DATA = -7;
  public static final int PARAM = -9;
  public static final int DESCRIPTION = -13;
  public static final int ON = 1;
  public static final int OFF = 2;
  public static final int GET_STATUS = 3;
  public static final int GET_DATA = 4;
  public static final int GET_CONT_DATA = 6;
  public static final int STOP_CONT_DATA = 7;
  public static final int GET_NEXT_DATA = 8;
  public static final int GET_PARAM = 9;
  public static final int SET_PARAM = 10;
  public static final int GET_DESCRIPTION = 13;

  private Type() {}
}
