// What the operator has to know, above all views: failures, changes that wait for a decision, other editors.

import { useSignal } from '@preact/signals';
import { useNow } from '../ui/connection';
import { Icon } from '../ui/icons';
import { needs } from '../ui/needs';
import type { ChangeUnderWay } from './apply';
import { type FileKey, fileOf, hostOf } from './draft';
import { useStudio } from './workshop';

export function Notices() {
  const { studio } = useStudio();
  void studio.revision.value;
  const { changes, failure } = studio;
  const { ended } = changes;
  return (
    <>
      {failure.value !== '' && (
        <div class="notice bad actions">
          <span role="alert">
            <Icon name="warning" /> {failure.value}
          </span>
          <span class="grow" />
          <Dismiss what="failure" run={() => (failure.value = '')} />
        </div>
      )}
      {studio.hosts.value
        .filter(({ list, trouble }) => list !== undefined && trouble !== '')
        .map(({ name, trouble }) => (
          <p key={name} class="notice bad" role="alert">
            {name}: {trouble}. Its files are shown as they were.
          </p>
        ))}
      {changes.underWay.value.map((change) => (
        <Change key={change.id} change={change} />
      ))}
      {ended.value !== undefined && (
        <div class={`notice actions ${ended.value.kept ? '' : 'bad'}`}>
          <span role={ended.value.kept ? 'status' : 'alert'}>{ended.value.text}</span>
          <span class="grow" />
          <Dismiss what="result" run={() => (ended.value = undefined)} />
        </div>
      )}
      {studio.conflicts.value.map((key) => (
        <Conflict key={key} file={key} />
      ))}
    </>
  );
}

function Dismiss({ what, run }: { what: string; run: () => void }) {
  return (
    <button type="button" class="quiet" aria-label={`Dismiss the ${what}`} onClick={run}>
      <Icon name="close" />
    </button>
  );
}

const stateTexts = {
  locked: 'is about to change',
  applying: 'is being applied on',
  waiting: 'works on',
  settling: 'is being kept on',
  going_back: 'is being taken back on',
};

// Counted down at every console, whoever made it.
function Change({ change }: { change: ChangeUnderWay }) {
  const { studio } = useStudio();
  const now = useNow(250);
  const { id, who, why, state, left, hosts } = change;
  const names = hosts.map(({ host }) => host).join(', ');
  if (state === 'locked')
    return (
      <div class="notice actions">
        <span role="status">
          {who} {stateTexts.locked} {names}
        </span>
      </div>
    );
  const seconds = left === undefined ? undefined : Math.max(0, left - (now - studio.changes.statesAt.value) / 1000);
  const waits = state === 'waiting';
  return (
    <section class="notice change" aria-label="Change under way">
      <p>
        <strong>“{why}”</strong> of {who} {stateTexts[state]} {names}.
      </p>
      {waits && (
        <p>
          Does everything still work? Without an answer the files before it come back in{' '}
          <strong class="count-down" role="timer">
            {Math.ceil(seconds ?? 0)} s
          </strong>
          .
        </p>
      )}
      {waits && (
        <p class="actions">
          <button type="button" class="primary" {...needs('conf_apply')} onClick={() => void studio.keepChange(id)}>
            Keep the change
          </button>
          <button type="button" {...needs('conf_apply')} onClick={() => void studio.undoChange(id)}>
            Undo it now
          </button>
          <span class="faint small">Keeping it first connects anew, to prove that the hosts can be reached.</span>
        </p>
      )}
    </section>
  );
}

function Conflict({ file }: { file: FileKey }) {
  const { studio } = useStudio();
  const report = useSignal('');
  const merge = () => {
    const merged = studio.merge(file);
    if (merged === undefined) report.value = 'One of you has removed the file: keep yours, or reload.';
    else if (merged.clashes.length > 0)
      studio.failure.value = `Both changed line ${merged.clashes.map(({ line }) => line).join(', ')} of ${fileOf(file)}: yours is kept. Theirs: ${merged.clashes.map(({ theirs }) => theirs.trim() || 'removed').join(' … ')}`;
  };
  return (
    <section class="notice bad actions" aria-label={`Conflict in ${fileOf(file)}`}>
      <span role="alert">
        <Icon name="warning" /> {fileOf(file)} on {hostOf(file)} was changed by another editor. {report.value}
      </span>
      <span class="grow" />
      <button type="button" class="primary" onClick={merge}>
        Merge
      </button>
      <button type="button" onClick={() => studio.reload(file)}>
        Reload theirs
      </button>
      <button type="button" onClick={() => studio.keep(file)}>
        Keep mine
      </button>
    </section>
  );
}
