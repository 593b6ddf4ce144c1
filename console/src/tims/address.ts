// Mailbox addresses: 32 bits of four fields, most significant first: system, class, instance, local. As text
// "Ladar(3/0)", and ":2" after it when the local id is not 0.

export interface Widths {
  system: number;
  classId: number;
  instance: number;
  local: number;
}

export interface Fields {
  system: number;
  classId: number;
  instance: number;
  local: number;
}

export const originalWidths: Widths = { system: 8, classId: 8, instance: 8, local: 8 };

// Classes of mailboxes that are no components.
export const classes = { router: 0x00, textSink: 0x01, gui: 0x02, joystick: 0x17, firstComponent: 0x10 } as const;

const mask = (bits: number) => 2 ** bits - 1;

// Values that exceed the width of their field are cut.
export function addressOf(fields: Partial<Fields>, widths: Widths): number {
  const { system = 0, classId = 0, instance = 0, local = 0 } = fields;
  let raw = system & mask(widths.system);
  raw = raw * 2 ** widths.classId + (classId & mask(widths.classId));
  raw = raw * 2 ** widths.instance + (instance & mask(widths.instance));
  return raw * 2 ** widths.local + (local & mask(widths.local));
}

export function fieldsOf(address: number, widths: Widths): Fields {
  const cut = (shift: number, bits: number) => Math.floor(address / 2 ** shift) & mask(bits);
  return {
    system: cut(32 - widths.system, widths.system),
    classId: cut(widths.instance + widths.local, widths.classId),
    instance: cut(widths.local, widths.instance),
    local: cut(0, widths.local),
  };
}

// The command mailbox of the component that a mailbox belongs to.
export function componentOf(address: number, widths: Widths): number {
  return address - fieldsOf(address, widths).local;
}

export function addressText(address: number, widths: Widths, className: (id: number) => string | undefined): string {
  const { system, classId, instance, local } = fieldsOf(address, widths);
  const name = className(classId) ?? `unknown[${classId.toString(16)}]`;
  return `${name}(${system}/${instance})${local === 0 ? '' : `:${local}`}`;
}
