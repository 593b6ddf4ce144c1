// Any data, field by field, with their units: what a class without a view of its own has.

import { useSignal } from '@preact/signals';
import { findMessage } from '../codec/catalogue';
import { hexDump } from '../codec/hex';
import type { Field } from '../codec/struct';
import { types } from '../tims/header';
import { useBytes, useStream } from '../ui/use_stream';
import { StreamBox, type ViewProperties } from './view';

const period = 200; // ms
const rowsMax = 100; // of a sequence
const bytesMax = 512;

export function FieldsView({ component }: ViewProperties) {
  const fields = findMessage(component.classId, types.data)?.body?.fields;
  return fields === undefined ? (
    <BytesView component={component} />
  ) : (
    <Described component={component} fields={fields} />
  );
}

// Of a class that is not described.
function BytesView({ component }: ViewProperties) {
  const stream = useBytes(component.address, period);
  const bytes = stream.value.value?.data;
  return (
    <StreamBox component={component} stream={stream}>
      {bytes !== undefined && (
        <>
          <p class="small faint">
            This class is not described here. Its data have {bytes.length} bytes
            {bytes.length > bytesMax && `; the first ${bytesMax}`}:
          </p>
          <pre class="hex">{hexDump(bytes.subarray(0, bytesMax))}</pre>
        </>
      )}
    </StreamBox>
  );
}

function Described({ component, fields }: ViewProperties & { fields: Field[] }) {
  const stream = useStream<Record<string, unknown>>(component.address, period);
  const si = useSignal(true);
  const data = stream.value.value?.data;
  return (
    <StreamBox component={component} stream={stream}>
      <label class="small">
        <input type="checkbox" checked={si.value} onChange={(event) => (si.value = event.currentTarget.checked)} /> SI
        units
      </label>
      {data !== undefined && <FieldTable fields={fields} data={data} si={si.value} />}
    </StreamBox>
  );
}

export function FieldTable({ fields, data, si }: { fields: Field[]; data: Record<string, unknown>; si: boolean }) {
  return (
    <table class="fields">
      <tbody>
        {fields.map((field) => (
          <FieldRow key={field.name} field={field} value={data[field.name]} si={si} />
        ))}
      </tbody>
    </table>
  );
}

function FieldRow({ field, value, si }: { field: Field; value: unknown; si: boolean }) {
  if (value === undefined) return null;
  return (
    <tr>
      <th scope="row">{field.name}</th>
      <td>
        <Value field={field} value={value} si={si} />
      </td>
    </tr>
  );
}

function Value({ field, value, si }: { field: Field; value: unknown; si: boolean }) {
  if (typeof value === 'number' || typeof value === 'bigint')
    return <Quantity field={field} value={Number(value)} si={si} />;
  if (value instanceof Uint8Array) return <span class="faint">{value.length} bytes</span>;
  if (Array.isArray(value)) return <List field={field} values={value} si={si} />;
  if (typeof value === 'object' && value !== null && field.inner !== undefined)
    return <FieldTable fields={field.inner.fields} data={value as Record<string, unknown>} si={si} />;
  return <>{value === null ? 'not a number' : String(value)}</>;
}

function Quantity({ field, value, si }: { field: Field; value: number; si: boolean }) {
  const factor = si ? (field.si ?? 1) : 1;
  const unit = si ? field.si_unit : field.unit;
  return (
    <span class="number">
      {numberText(value * factor)} {unit !== undefined && <span class="faint">{unit}</span>}
    </span>
  );
}

function List({ field, values, si }: { field: Field; values: unknown[]; si: boolean }) {
  const open = useSignal(false);
  return (
    <details onToggle={(event) => (open.value = event.currentTarget.open)}>
      <summary>{values.length}</summary>
      {open.value && (
        <ol start={0}>
          {values.slice(0, rowsMax).map((value, i) => (
            <li key={i}>
              <Value field={field} value={value} si={si} />
            </li>
          ))}
        </ol>
      )}
      {open.value && values.length > rowsMax && <p class="faint">and {values.length - rowsMax} more</p>}
    </details>
  );
}

function numberText(value: number): string {
  if (Number.isInteger(value)) return `${value}`;
  return value.toFixed(Math.abs(value) < 10 ? 3 : 2);
}
